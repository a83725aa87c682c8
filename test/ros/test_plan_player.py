"""Plan, execute, compare: the whole loop over real processes."""
import gc

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from test_cue import PATIENT

from billiard_shot import Scene
from billiard_shot.ros.plan_player import PLACES, PlanPlayer, play_plan

SPACE = '/loop'


def test_a_planned_shot_brings_the_ball_where_it_should(node, launch, capsys):
    gc.freeze()  # a long look for garbage would be a silence
    nodes = {**PATIENT, 'planner': ('-p', 'scene:=paper', '-p', 'plan_at_start:=false')}
    for name, arguments in nodes.items():
        launch(name, '-r', f'__ns:={SPACE}', *arguments)
    player = PlanPlayer(SPACE)
    player.wait_for_all()
    assert play_plan(player, PLACES[0], Scene.load('paper'))
    said = capsys.readouterr().out
    assert 'executed    OK' in said
    assert said.splitlines()[-1].endswith(': reached')
