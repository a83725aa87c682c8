"""Simulates billiard shots: the strike of the cue, and all balls until they rest."""

from importlib import import_module
from typing import Any, TYPE_CHECKING

from billiard_shot.notebook import Shown

if TYPE_CHECKING:
    from billiard_shot.calibration.calibrate import calibrate
    from billiard_shot.calibration.reader import read_recording
    from billiard_shot.calibration.result import Calibration
    from billiard_shot.impact.bodies import Body, Contact
    from billiard_shot.impact.collide import collide
    from billiard_shot.planning.candidate_strokes import candidates, CandidateStrokes
    from billiard_shot.planning.inverse import invert_strike
    from billiard_shot.planning.plan import plan
    from billiard_shot.planning.result import PlanResult, RankedStroke
    from billiard_shot.planning.shots import DirectShots, shots
    from billiard_shot.planning.within_noise import predict_within_noise
    from billiard_shot.scene import Scene
    from billiard_shot.scene.errors import InputError
    from billiard_shot.shot.aim import aim
    from billiard_shot.shot.analysis import effects_of, sensitivity_of
    from billiard_shot.shot.lowest_elevation import lowest_elevation
    from billiard_shot.shot.predict import predict, predict_batch
    from billiard_shot.shot.replay import load_shot, save_shot
    from billiard_shot.shot.shot import Shot
    from billiard_shot.shot.stroke import Stroke
    from billiard_shot.shot.stroke_batch import StrokeBatch
    from billiard_shot.status import Status
    from billiard_shot.table.effects import Effect
    from billiard_shot.table.motion import Motion
    from billiard_shot.table.run import TableRun
    from billiard_shot.table.simulate import simulate, simulate_batch
    from billiard_shot.table.table_batch import TableBatch
    from billiard_shot.table.table_states import TableStates
    from billiard_shot.table.trajectory import BallState, EventKind, Trajectory

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
    'StrokeBatch': 'shot.stroke_batch',
    'lowest_elevation': 'shot.lowest_elevation',
    'Shot': 'shot.shot',
    'load_shot': 'shot.replay',
    'save_shot': 'shot.replay',
    'Effect': 'table.effects',
    'effects_of': 'shot.analysis',
    'sensitivity_of': 'shot.analysis',
    'Status': 'status',
    'InputError': 'scene.errors',
    'Motion': 'table.motion',
    'Trajectory': 'table.trajectory',
    'BallState': 'table.trajectory',
    'EventKind': 'table.trajectory',
    'simulate': 'table.simulate',
    'simulate_batch': 'table.simulate',
    'TableBatch': 'table.table_batch',
    'TableStates': 'table.table_states',
    'TableRun': 'table.run',
    'plan': 'planning.plan',
    'PlanResult': 'planning.result',
    'RankedStroke': 'planning.result',
    'shots': 'planning.shots',
    'candidates': 'planning.candidate_strokes',
    'CandidateStrokes': 'planning.candidate_strokes',
    'predict_within_noise': 'planning.within_noise',
    'DirectShots': 'planning.shots',
    'invert_strike': 'planning.inverse',
    'calibrate': 'calibration.calibrate',
    'read_recording': 'calibration.reader',
    'Calibration': 'calibration.result',
    'collide': 'impact.collide',
    'Body': 'impact.bodies',
    'Contact': 'impact.bodies',
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


def _html_of(thing: object) -> str:
    html: str = import_module(f'{__name__}.pictures.notebook').html_of(thing)
    return html


Shown.html_of = _html_of


def __dir__() -> list[str]:
    return sorted(__all__)
