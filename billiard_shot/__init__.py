"""Simulates billiard shots: the strike of the cue, and all balls until they rest."""

from importlib import import_module
from typing import Any, TYPE_CHECKING

from billiard_shot.notebook import Shown

if TYPE_CHECKING:
    from billiard_shot.calibration.calibrate import calibrate
    from billiard_shot.calibration.reader import read_recording
    from billiard_shot.calibration.result import Calibration
    from billiard_shot.impact.collide import Body, collide, Contact
    from billiard_shot.planning.inverse import invert_strike
    from billiard_shot.planning.plan import candidates, CandidateStrokes, plan
    from billiard_shot.planning.result import PlanResult, RankedStroke
    from billiard_shot.planning.shots import DirectShots, shots
    from billiard_shot.planning.within_noise import predict_within_noise
    from billiard_shot.scene import Scene
    from billiard_shot.scene.errors import InputError
    from billiard_shot.shot.aim import aim
    from billiard_shot.shot.lowest_elevation import lowest_elevation
    from billiard_shot.shot.play import StrokeBatch
    from billiard_shot.shot.predict import effects_of, predict, predict_batch, sensitivity_of
    from billiard_shot.shot.replay import load_shot, save_shot
    from billiard_shot.shot.shot import Shot
    from billiard_shot.shot.stroke import Stroke
    from billiard_shot.status import Status
    from billiard_shot.table.model.motion import Motion
    from billiard_shot.table.run.effects import Effect
    from billiard_shot.table.run.results import BallState, EventKind, TableRun, Trajectory
    from billiard_shot.table.run.simulate import simulate, simulate_batch, TableBatch
    from billiard_shot.table.run.states import TableStates

__all__ = [
    'Scene',
    'Stroke',
    'aim',
    'predict',
    'predict_batch',
    'predict_within_noise',
    'StrokeBatch',
    'Shot',
    'lowest_elevation',
    'Status',
    'InputError',
    'Effect',
    'effects_of',
    'sensitivity_of',
    'Trajectory',
    'BallState',
    'EventKind',
    'Motion',
    'simulate',
    'simulate_batch',
    'TableBatch',
    'TableStates',
    'TableRun',
    'load_shot',
    'save_shot',
    'plan',
    'PlanResult',
    'RankedStroke',
    'shots',
    'DirectShots',
    'candidates',
    'CandidateStrokes',
    'invert_strike',
    'calibrate',
    'read_recording',
    'Calibration',
    'collide',
    'Body',
    'Contact',
]

# Imported when first used: `import billiard_shot` alone must not wait for NumPy.
_HOMES = {
    'Scene': 'scene',
    'Stroke': 'shot.stroke',
    'aim': 'shot.aim',
    'predict': 'shot.predict',
    'predict_batch': 'shot.predict',
    'StrokeBatch': 'shot.play',
    'lowest_elevation': 'shot.lowest_elevation',
    'Shot': 'shot.shot',
    'load_shot': 'shot.replay',
    'save_shot': 'shot.replay',
    'Effect': 'table.run.effects',
    'effects_of': 'shot.predict',
    'sensitivity_of': 'shot.predict',
    'Status': 'status',
    'InputError': 'scene.errors',
    'Motion': 'table.model.motion',
    'Trajectory': 'table.run.results',
    'BallState': 'table.run.results',
    'EventKind': 'table.run.results',
    'simulate': 'table.run.simulate',
    'simulate_batch': 'table.run.simulate',
    'TableBatch': 'table.run.simulate',
    'TableStates': 'table.run.states',
    'TableRun': 'table.run.results',
    'plan': 'planning.plan',
    'PlanResult': 'planning.result',
    'RankedStroke': 'planning.result',
    'shots': 'planning.shots',
    'candidates': 'planning.plan',
    'CandidateStrokes': 'planning.plan',
    'predict_within_noise': 'planning.within_noise',
    'DirectShots': 'planning.shots',
    'invert_strike': 'planning.inverse',
    'calibrate': 'calibration.calibrate',
    'read_recording': 'calibration.reader',
    'Calibration': 'calibration.result',
    'collide': 'impact.collide',
    'Body': 'impact.collide',
    'Contact': 'impact.collide',
}


def __getattr__(name: str) -> Any:
    if name == '__version__':
        value = import_module('importlib.metadata').version(__name__)
    elif name in _HOMES:
        value = getattr(import_module(f'{__name__}.{_HOMES[name]}'), name)
    else:
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    globals()[name] = value
    return value


Shown.pictures = lambda name: import_module(f'{__name__}.pictures.{name}')


def __dir__() -> list[str]:
    return sorted(__all__)
