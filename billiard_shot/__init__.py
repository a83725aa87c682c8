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
_NAMES = {
    'scene': 'Scene',
    'shot.stroke': 'Stroke',
    'shot.aim': 'aim',
    'shot.predict': 'predict predict_batch effects_of sensitivity_of',
    'shot.play': 'StrokeBatch',
    'shot.lowest_elevation': 'lowest_elevation',
    'shot.shot': 'Shot',
    'shot.replay': 'load_shot save_shot',
    'table.run.effects': 'Effect',
    'status': 'Status',
    'scene.errors': 'InputError',
    'table.model.motion': 'Motion',
    'table.run.results': 'Trajectory BallState EventKind TableRun',
    'table.run.simulate': 'simulate simulate_batch TableBatch',
    'table.run.states': 'TableStates',
    'planning.plan': 'plan candidates CandidateStrokes',
    'planning.result': 'PlanResult RankedStroke',
    'planning.shots': 'shots DirectShots',
    'planning.within_noise': 'predict_within_noise',
    'planning.inverse': 'invert_strike',
    'calibration.calibrate': 'calibrate',
    'calibration.reader': 'read_recording',
    'calibration.result': 'Calibration',
    'impact.collide': 'collide Body Contact',
}
_HOMES = {name: home for home, names in _NAMES.items() for name in names.split()}


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
