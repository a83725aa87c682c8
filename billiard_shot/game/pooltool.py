"""
The simulator pooltool (E. Kiefl) as a table: scenes, strokes, states and shots both ways.

Its frame has x across the table and y along it, from the corner of the head that is left for a
player there: the frame of scenes is turned by a right angle. Its azimuth is counted from its x,
and its side offset to the left. Needs the extra `pooltool`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
import math
from typing import Any

import numpy as np
import pooltool as pt
from pooltool.ai.action import Action
from pooltool.objects import CueSpecs
from pooltool.ruleset.datatypes import BallInHandOptions

from billiard_shot.game import Agent, find_agent, find_game, Outcome, State
from billiard_shot.game.rack import decision_of, MakeAgent
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL, Place
from billiard_shot.shot.stroke import Stroke

POCKETS = {
    'lb': 'head_left',
    'lc': 'side_left',
    'lt': 'foot_left',
    'rb': 'head_right',
    'rc': 'side_right',
    'rt': 'foot_right',
}
"""Names of pockets there, and here."""

CUSHIONS = {'stronge_compliant': 'stronge', 'mathavan_2010': 'mathavan'}
"""Names of models of the cushion there, and here; all others are nearest to `han`."""

GAMES = {'_EightBall': 'eight_ball', '_NineBall': 'nine_ball'}
"""Names of rule sets there, and here."""

GRIP = 2.0
"""Friction of the tip: no stroke of pooltool is a miscue."""

END_MASS = 0.74
"""
Part of the mass of the cue's end that gives the squirt of pooltool, which lets tip and ball part
without a rebound along the normal (Alciatore, technical proof TP A.31).
"""

PERIOD = 0.05
"""Time between places that a calibration sees [s]."""


@dataclass(frozen=True)
class Pooltool:
    """
    A table of pooltool, and the cue with which it is played. Its methods are simulators.

    Parameters
    ----------
    table : pooltool.Table
    ball : pooltool.BallParams
        Of all balls.
    cue : pooltool.objects.CueSpecs
    engine : pooltool.physics.PhysicsEngine
        By default the one that pooltool takes.

    """

    table: pt.Table = field(default_factory=pt.Table.default)
    ball: pt.BallParams = field(default_factory=pt.BallParams)
    cue: CueSpecs = field(default_factory=CueSpecs)
    engine: pt.physics.PhysicsEngine = field(default_factory=pt.physics.PhysicsEngine)

    @property
    def scene(self) -> Scene:
        """
        The table with the numbers of pooltool, without balls, noise and limits of a player.

        Contacts take no time, and the cue passes through balls and cushions. The coefficient of
        friction between balls is lower by 2 e / (1 + e): pooltool takes e v for the normal impulse
        per mass, which is (1 + e) v / 2.
        """
        ball, resolver = self.ball, self.engine.resolver
        weaker = ball.e_b / (0.5 * (1.0 + ball.e_b))
        law = getattr(resolver.ball_ball, 'friction', None)
        friction = {
            'friction_fast': weaker * (getattr(law, 'a', ball.u_b) if law else 0.0),
            'friction_slow': weaker * getattr(law, 'b', 0.0),
            'friction_decay': getattr(law, 'c', 0.0),
        }
        return Scene.from_dict(
            {
                'ball': {'mass': ball.m, 'radius': ball.R},
                'cue': {
                    'mass': self.cue.M,
                    'end_mass': END_MASS * self.cue.end_mass,
                    'length': 0.0,
                },
                'contacts': {
                    'cue_ball': {'restitution': 1.0, 'friction': GRIP, 'duration': 1.3e-3},
                    'ball_table': {'restitution': 0.5, 'friction': ball.u_s, 'duration': 0.7e-3},
                    'ball_ball': {'restitution': ball.e_b, 'duration': 0.0, **friction},
                },
                'cloth': {
                    'sliding_friction': ball.u_s,
                    'rolling_resistance': ball.u_r,
                    'gravity': ball.g,
                    'spin_deceleration': 2.5 * ball.u_sp_proportionality * ball.g,
                },
                'effects': dict.fromkeys(
                    ('flight', 'shaft', 'double_hit', 'table_contact'), 'off'
                ),
                'table': self._geometry(),
            }
        )

    def _geometry(self) -> dict[str, Any]:
        """
        Return the table of the scene.

        A ball of pooltool touches a nose if its centre is a radius away from it, seen from above.
        Here a ball touches if the surfaces do, `inset` nearer. So noses lie nearer to the middle,
        and jaws are rounder.
        """
        table, radius, model = self.table, self.ball.R, self.engine.resolver.ball_linear_cushion
        lines, arcs = table.cushion_segments.linear, table.cushion_segments.circular
        above = lines['3'].p1[2] - radius
        if model.model == 'stronge_compliant':  # its normal has that height at a radius
            above *= radius / math.hypot(radius, above)
        inset = radius - math.sqrt(radius**2 - above**2)
        found: dict[str, Any] = {
            'length': table.l - 2.0 * inset,
            'width': table.w - 2.0 * inset,
            'pockets': bool(table.pockets),
            'cushion': {
                'model': CUSHIONS.get(model.model, 'han'),
                'restitution': self.ball.e_c,
                'friction': self.ball.f_c,
                'fading': 0.0,
                'height': 0.5 * (1.0 + above / radius),
                'duration': 0.0,
            },
        }
        if ratio := getattr(model, 'omega_ratio', None):
            found['cushion']['frequency_ratio'] = ratio
        if not table.pockets:
            return found
        for name, facing, straight, hole in (('corner', '1', 0.0, 'lb'), ('side', '4', 1.0, 'lc')):
            away = lines[facing].p1 - lines[facing].p2
            along = abs(away[1 if straight else 0]) / math.hypot(*away[:2])
            turn, jaw = math.acos(along), arcs[f'{facing}t'].radius + inset
            tangent = jaw * math.tan(0.5 * turn)
            pocket = table.pockets[hole]
            if straight:  # from the middle of the mouth to where the straight nose begins
                mouth = 2.0 * (0.5 * table.l - lines['3'].p2[1] - tangent)
                beyond = inset - pocket.center[0]
            else:
                mouth = math.sqrt(2.0) * (lines['18'].p1[0] - inset - tangent)
                beyond = math.sqrt(2.0) * (inset - pocket.center[0]) + 0.5 * mouth
            found[name] = {
                'mouth': mouth,
                'cut_deg': 180.0 - math.degrees(turn),
                'jaw_radius': jaw,
                'shelf': beyond - pocket.radius,
                'radius': pocket.radius,
            }
        return found

    def system(self, scene: Scene, stroke: Stroke | None = None) -> pt.System:
        """Return a system with the balls of a scene, ready for a stroke."""
        balls = {
            name: pt.Ball.create(name, xy=there(self.table, place), **_numbers(self.ball))
            for name, place in scene.balls.items()
        }
        cue = pt.Cue(cue_ball_id=CUE_BALL, specs=self.cue)
        if stroke is not None:
            pooltool_action(stroke).apply(cue)
        return pt.System(cue=cue, table=self.table.copy(), balls=balls)

    def play(self, scene: Scene, stroke: Stroke, errors: np.random.Generator) -> pt.System:
        """Play a stroke with the noise of the scene."""
        played = scene.noise.perturb(stroke, errors, self.ball.R)
        return pt.simulate(self.system(scene, played), engine=self.engine, inplace=True)

    def foreign(self, scene: Scene, stroke: Stroke, errors: np.random.Generator) -> Outcome:
        """Play a stroke with the noise of the scene. A `Simulator` of games."""
        return outcome_of_system(self.play(scene, stroke, errors))

    def recorded(
        self, scene: Scene, stroke: Stroke, errors: np.random.Generator
    ) -> Mapping[str, Array]:
        """Play a stroke with the noise of the scene. A `TrackSimulator` of calibrations."""
        system = pt.continuize(self.play(scene, stroke, errors), dt=PERIOD, inplace=True)
        tracks = {}
        for name, ball in system.balls.items():
            states, kinds, times = ball.history_cts.vectorize()
            last = kinds != pt.constants.pocketed
            xy = here(system.table, states[:, 0, :2])
            tracks[name] = np.column_stack([times, xy])[last]
        return tracks


def _numbers(ball: pt.BallParams) -> dict[str, float]:
    names = 'm', 'R', 'u_s', 'u_r', 'u_sp_proportionality', 'u_b', 'e_b', 'e_c', 'f_c', 'g'
    return {name: getattr(ball, name) for name in names}


def here(table: pt.Table, places: Array) -> Array:
    """Return places of pooltool (..., 2) [m] in the frame of the scene."""
    x, y = np.moveaxis(np.asarray(places, float), -1, 0)
    return np.stack([y - 0.5 * table.l, 0.5 * table.w - x], axis=-1)


def there(table: pt.Table, place: Place) -> Place:
    """Return a place (x, y) [m] of the scene in the frame of pooltool."""
    x, y = place
    return 0.5 * table.w - y, x + 0.5 * table.l


def pooltool_action(stroke: Stroke) -> Action:
    """Return a stroke as pooltool has it."""
    a, b, elevation, azimuth, speed = stroke.offsets
    return Action(speed, math.degrees(azimuth) + 90.0, math.degrees(elevation), -a, b)


def stroke_of_action(action: Action | pt.Cue) -> Stroke:
    """Return the stroke of an action, or of a cue that is ready."""
    return Stroke.from_offsets(
        -action.a,
        action.b,
        elevation_deg=action.theta,
        azimuth_deg=action.phi - 90.0,
        speed=action.V0,
    )


def balls_of(system: pt.System) -> dict[str, Place]:
    """Return the places of the balls that are on the table [m]."""
    return {
        name: tuple(here(system.table, ball.state.rvw[0, :2]).tolist())
        for name, ball in system.balls.items()
        if ball.state.s != pt.constants.pocketed
    }


def outcome_of_system(system: pt.System) -> Outcome:
    """Read the outcome of a system that was simulated."""
    kinds = pt.EventType
    pocketed: list[tuple[str, str]] = []
    met: dict[str, int] = {}
    to_cushion: set[str] = set()
    cushions, crossed, from_kitchen = 0, False, False
    kitchen_end = -0.25 * float(system.table.l)
    for event in system.events:
        if event.event_type == kinds.BALL_POCKET:
            ball, pocket = event.ids
            pocketed.append((ball, POCKETS[pocket]))
        elif event.event_type == kinds.BALL_BALL and CUE_BALL in event.ids:
            (other,) = (agent for agent in event.agents if agent.id != CUE_BALL)
            if not met:
                x, _ = here(system.table, other.initial.state.rvw[0, :2]).tolist()
                from_kitchen = x < kitchen_end and not crossed
            met.setdefault(other.id, cushions)
        elif event.event_type in (kinds.BALL_LINEAR_CUSHION, kinds.BALL_CIRCULAR_CUSHION):
            ball = event.agents[0]
            if ball.id == CUE_BALL:
                cushions += 1
                x, _ = here(system.table, ball.initial.state.rvw[0, :2]).tolist()
                crossed |= x >= kitchen_end
            if met:
                to_cushion.add(ball.id)
    return Outcome(
        first_contact=next(iter(met), None),
        pocketed=tuple(pocketed),
        to_cushion=frozenset(to_cushion),
        from_kitchen=from_kitchen,
        met=tuple(met),
        cushions_before=tuple(met.values()),
        places=balls_of(system),
    )


IN_HAND = {
    BallInHandOptions.NONE: '',
    BallInHandOptions.ANYWHERE: 'anywhere',
    BallInHandOptions.BEHIND_LINE: 'kitchen',
    BallInHandOptions.SEMICIRCLE: 'kitchen',
}


def state_of_system(system: pt.System, rules: pt.ruleset.Ruleset) -> State:
    """
    Return the state of a game of pooltool; the cue ball in hand is not on the table.

    Raises
    ------
    ValueError
        If the rules are not those of eight- or nine-ball.

    """
    kind = type(rules).__name__
    if kind not in GAMES:
        raise ValueError(f'rules must be one of {", ".join(GAMES)}, got {kind}')
    wanted = rules.shot_constraints
    balls = balls_of(system)
    in_hand = IN_HAND[wanted.ball_in_hand]
    if in_hand:
        balls.pop(CUE_BALL, None)
    groups = ('', '')
    if kind == '_EightBall':
        mine, player = rules.active_group.name.lower(), rules.active_idx
        if mine in ('solids', 'stripes'):
            other = 'stripes' if mine == 'solids' else 'solids'
            groups = (mine, other) if player == 0 else (other, mine)
    return State(
        game=find_game(GAMES[kind]),
        length=system.table.l,
        width=system.table.w,
        radius=next(iter(system.balls.values())).params.R,
        balls=balls,
        player=rules.active_idx,
        phase='play' if rules.shot_number else 'break',
        in_hand=in_hand,
        groups=groups,
        shots=rules.shot_number,
    )


class Ai:
    """
    A player for pooltool: what its `Player` has as `ai`.

    Parameters
    ----------
    scene : Scene
        With which it plans, such as `Pooltool().scene`.
    make : str or callable
        The name of an agent, see `find_agent`, or what makes it.
    seed : int

    """

    def __init__(self, scene: Scene, make: str | MakeAgent = 'player', seed: int = 1) -> None:
        self.agent: Agent = (find_agent(make) if isinstance(make, str) else make)(scene, seed)

    def decide(self, system: pt.System, game: pt.ruleset.Ruleset, callback: Any = None) -> Action:
        """Place the cue ball if it is in hand, call ball and pocket, and return the stroke."""
        seen, decision, why = decision_of(self.agent, state_of_system(system, game))
        if decision.stroke is None:
            raise ValueError(f'the player finds no stroke: {why or decision.reason}')
        system.balls[CUE_BALL].state.rvw[0, :2] = there(system.table, seen.balls[CUE_BALL])
        names = {name: pocket for pocket, name in POCKETS.items()}
        game.shot_constraints.ball_call = decision.call.ball
        game.shot_constraints.pocket_call = names.get(decision.call.pocket)
        action = pooltool_action(decision.stroke)
        if callback is not None:
            callback(action)
        return action

    def apply(self, system: pt.System, action: Action) -> None:
        """Make the cue ready."""
        action.apply(system.cue)
