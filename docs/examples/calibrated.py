import math

from billiard_shot import BallState, calibrate, read_recording, Scene, simulate

table = Scene.load('carom').with_parameters(['cloth.sliding_friction'], [0.23])  # to be found
places = {'white': (-0.8, 0.2), 'yellow': (0.3, 0.1)}
with open('shots.csv', 'w') as file:
    file.write('shot,time,ball,x,y\n')
    for shot in range(6):
        angle, speed = 0.5 * shot, 2.0 + 0.2 * shot
        balls = {name: BallState((*place, 0.03075)) for name, place in places.items()}
        velocity = speed * math.cos(angle), speed * math.sin(angle), 0.0
        balls['white'] = BallState((*places['white'], 0.03075), velocity)
        run = simulate(table, balls, until=0.8)
        for frame in range(-5, 40):
            for name, state in run.at(max(0.02 * frame, 0.0)).items():
                x, y, _ = state.position
                file.write(f'{shot},{0.02 * frame + 0.1:.2f},{name},{x:.4f},{y:.4f}\n')

recording = read_recording('shots.csv')
found = calibrate(recording, 'carom', names=['cloth.sliding_friction'], horizon=0.5, held_out=0.15)
print(found)  # Calibration(converged, 4 of 4 numbers identified, 5 shots fitted)
print(f'{found.estimates[0].value:.2f}')  # 0.23
seen = found.predict(recording.shots[5], seen=0.3)  # from the first 0.3 s of the shot
print(seen.rmse(until=0.5) < 0.005)  # True
found.save('my_table.yaml')
found.report('report.html')
