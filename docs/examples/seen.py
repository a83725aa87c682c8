"""Rule on a shot that somebody saw."""

from billiard_shot.game import Call, judge, Outcome, start

state = start('nine_ball', 'seven_foot').with_cue_ball(-0.6, 0.15)
seen = Outcome('2', (('9', 'foot_left'),), places={'cue': (0, 0), '1': (0.5, 0)})
print(judge(state, Call(), seen).fouls[0])  # 6.2: ball 2 is met first
