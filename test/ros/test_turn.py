"""Turns of games with the mechanical cue: real processes, and rulings from pictures."""

from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import partial
import os
import re
import signal
import subprocess
import threading
from types import SimpleNamespace
import warnings

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from action_msgs.msg import GoalStatus
from billiard_shot_msgs.action import PlayTurn
from billiard_shot_msgs.msg import GameState, TableState
from billiard_shot_msgs.srv import PlaceBalls, RuleShot
from cell import PATIENT, STARTS
from hypothesis import given, strategies
from rclpy.action import ActionClient
from waiting import PATIENCE, PatientCaller

from billiard_shot import Scene, Stroke
from billiard_shot.cue.plan import GoalOutcome
from billiard_shot.game.referee import start
from billiard_shot.game.state import Call, Decision, Outcome, State
from billiard_shot.perception.sightings import moved, Sighting
from billiard_shot.ros.client import CanceledError, NotReadyError, TableUnknownError
from billiard_shot.ros.turn import (
    balls_message,
    game_state_message,
    GameTable,
    state_of,
    Turn,
    TurnStage,
)

SPACE = '/turn'
SCENE = Scene.load('robot_table')
ON_IT = ('-p', 'scene:=robot_table')
NODES = {
    'cue_driver': (*PATIENT['cue_driver'], *ON_IT),
    'cue_sim': PATIENT['cue_sim'],
    'table_sim': (*PATIENT['table_sim'], *ON_IT),
    'predictor': (),
}
BALLS = {'cue': (-0.4, 0.0), '1': (0.6, 0.3), '9': (0.1, -0.4)}


def game_of(name, balls=BALLS, **fields):
    state = replace(start(name, SCENE), phase='play', in_hand='', balls=balls)
    return replace(state, **fields)


def test_states_there_and_back():
    states = [
        game_of('practice'),
        game_of(
            'eight_ball',
            BALLS | {'8': (0.2, 0.2)},
            groups=('stripes', 'solids'),
            fouls=(1, 0),
            player=1,
            shots=7,
        ),
        game_of('straight_pool', scores=(-3, 12), target=100, over=True, winner=1),
        replace(start('nine_ball', SCENE, seed=5), in_hand='kitchen', choices=('accept', 'pass')),
    ]
    for state in states:
        assert state_of(game_state_message(state), state.balls, SCENE) == state
    with pytest.raises(ValueError, match='phase'):
        state_of(GameState(game='practice', phase='middle'), BALLS, SCENE)
    with pytest.raises(ValueError, match="'cricket'"):
        state_of(GameState(game='cricket'), BALLS, SCENE)


TEXTS = strategies.text(max_size=5) | strategies.sampled_from(
    [
        'practice',
        'eight_ball',
        'nine_ball',
        '../../x',
        'play',
        'break',
        'kitchen',
        'pass',
        'solids',
    ]
)


@given(
    game=TEXTS,
    player=strategies.integers(0, 255),
    phase=TEXTS,
    in_hand=TEXTS,
    choices=strategies.lists(TEXTS, max_size=3) | strategies.just(['accept'] * 100_000),
    groups=strategies.lists(TEXTS, min_size=2, max_size=2),
    fouls=strategies.lists(strategies.integers(-(2**31), 2**31 - 1), min_size=2, max_size=2),
    winner=strategies.integers(-128, 127),
    over=strategies.booleans(),
    balls=strategies.dictionaries(
        strategies.sampled_from(['cue', '1', '15', '16', '\x1b[2J']),
        strategies.tuples(strategies.floats(), strategies.floats()),
    ),
)
def test_any_message_is_a_state_or_is_refused(balls, **fields):
    with suppress(ValueError):
        state = state_of(GameState(**fields), balls, SCENE)
        assert state.choices or state.over or state.in_hand or 'cue' in state.balls


# --- what pictures do not show -------------------------------------------------------------------


class Client:
    """
    Client of a robot that plays every stroke; a camera then sees the balls at `after`.

    Balls whose names are `hidden` are not seen then.
    """

    def __init__(self, before, after, error=None, cancel_at=None, stopped=False, hidden=()):
        self.seen, self.after, self.error, self.hidden = before, after, error, hidden
        self.cancel_at, self.stopped = cancel_at, stopped
        self.is_canceled = self.goes_on = False

    def reach(self, moment):
        """Cancel at a moment, which ends the wait unless the client goes on to the end."""
        self.is_canceled |= moment == self.cancel_at
        if self.is_canceled and not self.goes_on:
            raise CanceledError('canceled')

    @contextmanager
    def to_the_end(self):
        self.goes_on = True
        yield
        self.goes_on = False

    def create_subscription(self, *_):
        return None

    def create_client(self, *_):
        return SimpleNamespace(service_is_ready=lambda: True)

    def call(self, client, request, attempts=1):
        """Reset the tracker, which finds the balls again that are not hidden."""
        self.after = self.seen = {
            name: place for name, place in self.after.items() if name not in self.hidden
        }

    def count_publishers(self, topic):
        return 0

    def get_logger(self):
        return SimpleNamespace(error=lambda text: None)

    def until(self, condition, seconds):
        while not condition():
            pass
        return True

    def wait_for_rest(self, strike=None, unseen_time=None):
        if self.error:
            raise self.error
        if strike:
            self.reach('watch')
            self.seen = self.after
        return self.balls()

    def balls(self):
        hidden = self.hidden if self.seen is self.after else ()
        return {
            name: Sighting(place, is_seen=name not in hidden) for name, place in self.seen.items()
        }

    def goal(self, stroke, balls, scene, name):
        return SimpleNamespace(plan=SimpleNamespace(shot_id=f'{name} new', balls=balls))

    def execute(self, goal, may_fire, on_aimed):
        assert not hasattr(goal, 'allow_miscue')  # the driver refuses a tip that would slide
        on_aimed()
        self.reach('aimed')
        assert may_fire()
        self.is_canceled |= self.cancel_at == 'firing'
        if problem := moved(goal.plan.balls, self.wait_for_rest(), 1e-3):  # as the driver does
            result = SimpleNamespace(
                outcome=GoalOutcome.TABLE_DIFFERS, message=problem, struck=False, measured=False
            )
            return SimpleNamespace(status=GoalStatus.STATUS_ABORTED, result=result)
        strike = SimpleNamespace(header=SimpleNamespace(stamp=1))
        outcome, message = (4, 'the emergency stop') if self.stopped else (0, 'done')
        status = GoalStatus.STATUS_ABORTED if self.stopped else GoalStatus.STATUS_SUCCEEDED
        result = SimpleNamespace(
            strike=strike, struck=True, measured=True, outcome=outcome, message=message
        )
        return SimpleNamespace(status=status, result=result)


class Shooter:
    """Agent that calls the 1 into one pocket, whatever happens."""

    def decide(self, state):
        return Decision(Stroke.from_offsets(speed=1.0), Call(ball='1', pocket='foot_left'))

    def saw(self, state, decision, ruling):
        pass


def turn_of(client, state, asked=None, agent=None):
    told = []

    def ask(shot_id, before, places, is_over):
        assert asked, 'nobody has to be asked'
        if callable(asked):
            asked()
        return None if is_over() else asked

    tell = lambda stage, message, shot_id, balls: told.append((stage, message))  # noqa: E731
    return Turn(GameTable(client, SCENE), agent or Shooter(), tell, ask, True, state), told


def without(*names):
    return {name: place for name, place in BALLS.items() if name not in names}


def test_a_ruling_that_pictures_show_needs_nobody():
    """The cue ball has fallen: the other player is next, whatever else happened."""
    state = game_of('eight_ball', groups=('solids', 'stripes'))
    turn, told = turn_of(Client(BALLS, without('cue', '1')), state)
    assert turn.play() == (PlayTurn.Result.TURN_ENDED, 'player 1 is next')
    assert turn.state.in_hand == 'anywhere'
    assert TurnStage.RULE not in [stage for stage, _ in told]
    assert turn.shots[0].gone == ['cue', '1']


def test_somebody_is_asked_for_what_pictures_do_not_show():
    """Whether the 1 fell where it was called decides about the turn."""
    after, state = without('1'), game_of('eight_ball', groups=('solids', 'stripes'))
    for pocket, player in (('foot_left', 0), ('side_left', 1)):
        seen = Outcome(first_contact='1', pocketed=(('1', pocket),), places=after)
        turn, told = turn_of(Client(BALLS, after), state, seen)
        turn._go_on()
        assert TurnStage.RULE in [stage for stage, _ in told]
        assert turn.state.player == player
        assert turn.state.balls == after


def test_somebody_is_asked_whether_a_ball_that_is_not_seen_was_potted():
    """The tracker then forgets the ball, so that the turn can go on."""
    outcome = Outcome(first_contact='1', pocketed=(('1', 'foot_left'),), places=without('1'))
    client = Client(BALLS, dict(BALLS), hidden=['1'])
    turn, told = turn_of(client, game_of('practice'), outcome)
    turn._go_on()
    question = "ball '1' not seen: potted? If not, let the camera see it"
    assert (TurnStage.RULE, question) in told
    assert turn.shots[0].gone == ['1']
    assert client.balls().keys() == turn.state.balls.keys() == without('1').keys()


def test_a_turn_says_that_the_tracker_cannot_forget_a_potted_ball():
    outcome = Outcome(first_contact='1', pocketed=(('1', 'foot_left'),), places=without('1'))
    turn, told = turn_of(Client(BALLS, dict(BALLS), hidden=['1']), game_of('practice'), outcome)
    turn.table._forget = SimpleNamespace(service_is_ready=lambda: False)
    turn._go_on()
    said = 'table_tracker/reset is not there: balls that are gone stay in table_state'
    assert told[-1] == (TurnStage.WATCH, said)


def test_a_ball_that_has_fallen_is_gone_though_the_tracker_still_tells_of_it():
    """A simulated table knows first; the turn would wait for the ball in vain."""
    fallen = Outcome(first_contact='1', pocketed=(('1', 'foot_left'),))
    client = Client(BALLS, dict(BALLS))
    turn, _ = turn_of(client, game_of('practice'))
    turn.table.record = lambda: fallen
    client.call = lambda *_, **__: setattr(client, 'seen', without('1'))
    turn._go_on()
    assert turn.shots[0].gone == ['1']
    assert client.balls().keys() == turn.state.balls.keys() == without('1').keys()


def test_nobody_needs_to_answer_once_the_camera_sees_the_ball():
    client = Client(BALLS, dict(BALLS), hidden=['1'])
    turn, told = turn_of(client, game_of('practice'), lambda: setattr(client, 'hidden', ()))
    turn._go_on()
    assert [stage for stage, _ in told].count(TurnStage.RULE) == 1
    assert told[-1][0] == TurnStage.JUDGED
    assert turn.shots[0].gone == []
    assert turn.state.balls == BALLS


@pytest.mark.parametrize(
    ('error', 'outcome'),
    [
        (TableUnknownError("ball '9' is not seen"), PlayTurn.Result.TABLE_UNKNOWN),
        (NotReadyError('cue_driver: no such node is known so far'), PlayTurn.Result.NOT_READY),
        (CanceledError('canceled'), PlayTurn.Result.CANCELED),
    ],
)
def test_a_turn_that_cannot_go_on_says_why(error, outcome):
    turn, _ = turn_of(Client(BALLS, BALLS, error), game_of('practice'))
    assert turn.play() == (outcome, str(error))
    assert turn.state == game_of('practice')


@pytest.mark.parametrize('moment', ['firing', 'watch'])
def test_a_cancel_after_the_strike_waits_for_the_ruling(moment):
    """Before, the state was that before the shot, although the balls lay elsewhere."""
    after, state = without('1'), game_of('eight_ball', groups=('solids', 'stripes'))
    seen = Outcome(first_contact='1', pocketed=(('1', 'foot_left'),), places=after)
    turn, told = turn_of(Client(BALLS, after, cancel_at=moment), state, seen)
    assert turn.play() == (PlayTurn.Result.CANCELED, 'canceled')
    assert turn.state.shots == 1
    assert turn.state.balls == after
    assert told[-1][0] == TurnStage.JUDGED


def test_a_cancel_before_the_strike_ends_the_turn():
    turn, _ = turn_of(Client(BALLS, BALLS, cancel_at='aimed'), game_of('practice'))
    assert turn.play() == (PlayTurn.Result.CANCELED, 'canceled')
    assert turn.state == game_of('practice')


def test_a_stroke_that_was_stopped_after_it_met_the_ball_is_judged():
    state = game_of('eight_ball', groups=('solids', 'stripes'))
    turn, _ = turn_of(Client(BALLS, without('cue'), stopped=True), state)
    assert turn.play() == (PlayTurn.Result.TURN_ENDED, 'player 1 is next')
    after = without('1')
    seen = Outcome(first_contact='1', pocketed=(('1', 'foot_left'),), places=after)
    turn, _ = turn_of(Client(BALLS, after, stopped=True), state, seen)
    assert turn.play() == (PlayTurn.Result.NOT_PLAYED, 'ESTOP: the emergency stop')
    assert (turn.state.player, turn.state.balls) == (0, after)


class Failing(Shooter):
    """Agent of somebody else, which fails in one of its methods."""

    def __init__(self, method, result=None, error=None):
        def fail(*_):
            if error:
                raise error
            return result

        setattr(self, method, fail)


@pytest.mark.parametrize(
    ('agent', 'said'),
    [
        (Failing('decide', error=ZeroDivisionError('no idea')), "ZeroDivisionError('no idea')"),
        (Failing('decide', error=SystemExit(3)), 'SystemExit(3)'),
        (Failing('decide', result='a stroke'), "must return a Decision, got 'a stroke'"),
        (Failing('place', result=None), 'TypeError'),
        (Failing('saw', error=KeyError('shots')), "KeyError('shots')"),
    ],
)
def test_an_agent_that_fails_ends_the_turn_with_the_reason(agent, said):
    state = game_of('eight_ball', groups=('solids', 'stripes'))
    if 'place' in vars(agent):
        state = replace(state, in_hand='anywhere', balls=without('cue'))
    turn, _ = turn_of(Client(BALLS, without('cue', '1')), state, agent=agent)
    outcome, message = turn.play()
    assert outcome == PlayTurn.Result.AGENT_FAILED
    assert said in message
    assert len(turn.shots) == ('saw' in vars(agent)), 'a shot that was played is not forgotten'


class Thinking(Shooter):
    """Agent that thinks while somebody moves a ball by 3 mm."""

    def __init__(self, put):
        self.put = put

    def decide(self, state):
        x, y = state.balls['9']
        self.put({**state.balls, '9': (x + 0.003, y)})
        return super().decide(state)


def test_a_stroke_is_not_played_if_a_ball_has_moved_since_the_agent_was_asked():
    client, state = Client(BALLS, BALLS), game_of('practice')
    turn, _ = turn_of(client, state, agent=Thinking(partial(setattr, client, 'seen')))
    outcome, message = turn.play()
    assert outcome == PlayTurn.Result.NOT_PLAYED
    assert message.startswith("TABLE_DIFFERS: ball '9' lies 3 mm from its planned place")
    assert not turn.shots
    assert turn.state == state


# --- real processes -----------------------------------------------------------------------------


class Late(Client):
    """Client that discovers a simulated table late, which puts the balls in their places."""

    looks = 0

    def create_client(self, *_):
        return SimpleNamespace(service_is_ready=self.is_discovered)

    def is_discovered(self):
        self.looks += 1
        return self.looks > 3

    def call(self, client, request, attempts=1):
        self.seen = {each.id: (each.position.x, each.position.y) for each in request.balls}
        return SimpleNamespace(success=True)

    def until(self, condition, seconds):
        return any(condition() for _ in range(10))


def test_a_simulated_table_that_is_discovered_late_puts_the_balls_in_their_places():
    """Before, a client that had just started waited for hands, for ten minutes."""
    table = GameTable(Late({**BALLS, '9': (0.0, 0.0)}, None), SCENE)
    state, seen = table.arrange(game_of('practice'), lambda *_: None)
    assert state.balls == BALLS
    assert seen.keys() == BALLS.keys()


AGENT = """
class Agent:
    def decide(self, state):
        raise RuntimeError('no idea')

def make(scene, seed):
    return Agent()
"""


@pytest.fixture
def server(cell, launch_once, tmp_path, monkeypatch):
    """Client of the action `play_turn`, and of the service that rules, of a process of its own."""
    (tmp_path / 'failing').mkdir()
    (tmp_path / 'failing' / 'agent.py').write_text(AGENT)
    monkeypatch.setenv('PYTHONPATH', str(tmp_path), prepend=os.pathsep)

    def answered(action):
        """Whether the server knows this client. Until then, answers to the client are lost."""
        if not action.server_is_ready():
            return False
        sent = action.send_goal_async(PlayTurn.Goal(state=GameState(game='cricket')))
        if not cell.player.until(sent.done, 5.0) or not sent.result().accepted:
            return False
        return cell.player.until(sent.result().get_result_async().done, 5.0)

    for left in reversed(range(STARTS)):
        process = launch_once(
            *('player', '-r', f'__ns:={SPACE}', '--', '--serve', '--scene', 'robot_table'),
            *('--modules', 'failing.agent'),
        )
        action = ActionClient(cell.player, PlayTurn, f'{SPACE}/play_turn')
        if cell.player.until(partial(answered, action), PATIENCE / 2):
            break
        assert left, 'the server has never heard this client'
        warnings.warn('the server of turns is started again', stacklevel=2)
        launch_once.close()
        action.destroy()
    yield action, PatientCaller(cell.player, RuleShot, f'{SPACE}/player/rule_shot')
    action.destroy()
    process.send_signal(signal.SIGTERM)
    assert process.wait(PATIENCE) == 0


def begin(cell, action, goal, feedback):
    sent = action.send_goal_async(goal, lambda message: feedback.append(message.feedback))
    assert cell.player.until(sent.done, PATIENCE)
    return sent.result()


def ended(cell, handle):
    result = handle.get_result_async()
    assert cell.player.until(result.done, PATIENCE)
    return result.result()


def test_the_action_plays_a_turn(cell, server):
    action, rule = server
    place = PatientCaller(cell.player, PlaceBalls, f'{SPACE}/table_sim/place')
    assert place.wait_for_service()
    assert place.call(PlaceBalls.Request(balls=balls_message(BALLS)), repeatable=True).success
    assert cell.player.until(lambda: len(cell.player.table.balls) == 3, PATIENCE)
    beyond = PlaceBalls.Request(balls=balls_message({**BALLS, '9': (1e160, 0.0)}))
    assert "ball '9': position.x must be from" in place.call(beyond, repeatable=True).message
    refused = rule.call(RuleShot.Request(shot_id='another'), repeatable=True)
    assert not refused.success
    assert 'shot_id must be' in refused.message

    for game, agent, words in (
        ('cricket', '', "state.game must be one of .*, got 'cricket'"),
        ('../../x', '', r"state.game .*, got '\.\./\.\./x'"),
        ('failing.another', '', "got 'failing.another'"),
        ('practice', 'os.path', "agent must be one of .*, got 'os.path'"),
        ('practice', 'player:effort=much', 'effort must be a number'),
    ):
        bad = PlayTurn.Goal(state=GameState(game=game), agent=agent)
        answer = ended(cell, begin(cell, action, bad, []))
        assert answer.status == GoalStatus.STATUS_ABORTED
        assert answer.result.outcome == PlayTurn.Result.INVALID
        assert re.search(words, answer.result.message), answer.result.message

    goal = PlayTurn.Goal(state=GameState(game='practice', phase='play'), agent='failing.agent')
    answer = ended(cell, begin(cell, action, goal, []))
    assert answer.status == GoalStatus.STATUS_ABORTED
    assert answer.result.outcome == PlayTurn.Result.AGENT_FAILED
    assert answer.result.message == "the agent has failed: RuntimeError('no idea')"

    said = []
    goal.agent = 'greedy'
    handle = begin(cell, action, goal, said)
    assert handle.accepted
    assert not begin(cell, action, goal, []).accepted, 'one turn at a time'
    assert cell.player.until(lambda: any(each.shot_id for each in said), PATIENCE)
    handle.cancel_goal_async()
    answer = ended(cell, handle)
    assert answer.status == GoalStatus.STATUS_CANCELED
    assert answer.result.outcome == PlayTurn.Result.CANCELED
    assert not answer.result.shots

    goal.arm, said = True, []
    answer = ended(cell, begin(cell, action, goal, said))
    assert answer.result.outcome == PlayTurn.Result.OVER, answer.result.message
    shots = answer.result.shots
    assert [each.shot_id for each in shots] == [
        each.shot_id for each in said if each.stage == TurnStage.JUDGED
    ]
    assert answer.result.state.shots == len(shots)
    left = {ball.id for ball in answer.result.balls}
    assert left == {'cue', '1', '9'} - {ball for shot in shots for ball in shot.gone}
    assert isinstance(cell.player.table, TableState)


def test_a_turn_at_the_terminal(cell, launch_once, tmp_path):
    """The operator types `fire` for each shot; the file has the game after the turn."""
    state = start('practice', SCENE, seed=1, balls=1)
    file = tmp_path / 'game.json'
    state.save(file)
    process = launch_once(
        *('player', '-r', f'__ns:={SPACE}', '--'),
        *('--state', str(file), '--scene', 'robot_table', '--agent', 'greedy'),
        stdin=subprocess.PIPE,
    )
    said = []

    def type_fire():
        for line in process.stdout:
            said.append(line)
            if ' aimed;' in line:
                process.stdin.write('?\nfire\n')
                process.stdin.flush()

    operator = threading.Thread(target=type_fire)
    operator.start()
    assert cell.player.until(lambda: process.poll() is not None, PATIENCE), said
    operator.join()
    assert process.returncode in (0, 1), said
    assert any('"?" is not asked for now' in line for line in said)
    assert any(line.startswith('  ruling ') for line in said), said
    assert said[-1].startswith('  turn        '), said
    after = State.load(file)
    assert after.over
    assert after.shots > 0
