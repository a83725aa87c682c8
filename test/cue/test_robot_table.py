"""The scene `robot_table`: a pool table at which the mechanical cue plays."""

from plans import sightings

from billiard_shot import plan, Scene, Status
from billiard_shot.cue.mechanism import Mechanism
from billiard_shot.cue.plan import prepare_shot, ShotPlan, tip_at

SCENE = Scene.load('robot_table')
RUN_UP = 0.05  # m


def test_the_cue_is_that_of_the_paper_and_the_table_a_pool_table():
    paper, pool = Scene.load('paper'), Scene.load('pool_table')
    assert SCENE.cue == paper.cue
    tip, of_paper = SCENE.contacts.cue_ball, paper.contacts.cue_ball
    assert (tip.restitution, tip.friction) == (of_paper.restitution, of_paper.friction)
    assert (SCENE.table, SCENE.ball, SCENE.cloth) == (pool.table, pool.ball, pool.cloth)
    assert SCENE.contacts.ball_table == pool.contacts.ball_table


def test_the_mechanism_can_play_what_is_planned():
    result = plan(SCENE, {'pot': '8', 'pocket': 'any'}, budget=2000, seed=1)
    assert result.status is Status.OK, result.message
    assert result.best.success > 0.2
    for planned in result.ranking:
        stroke = planned.stroke
        tip = tip_at(stroke, SCENE.balls['cue'], SCENE)
        before = tuple((tip.position - RUN_UP * tip.along).tolist())
        prepare_shot(
            Mechanism(),
            SCENE,
            ShotPlan(  # raises where it cannot
                planned.kind,
                before,
                tip.quaternion,
                stroke.speed,
                tip.elevation,
                sightings(SCENE.balls),
            ),
        )
