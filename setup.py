"""Package of haul_ros, for pip and as ament_python package for colcon."""

import re
from pathlib import Path

from setuptools import find_packages, setup

NAME = "haul_ros"
HERE = Path(__file__).resolve().parent  # colcon --symlink-install runs a link to this file
SHARE = f"share/{NAME}"
VERSION = re.search(r'__version__ = "(.+)"', (HERE / NAME / "version.py").read_text(encoding="utf-8")).group(1)

# Of what counts its versions by the calendar or four times a year, the newest that was tried.
PARQUET = ["pyarrow>=15,<27"]
FATIGUE = ["rainflow>=3.2,<4"]
VIEW = ["tornado>=6.4,<7", "rich>=13,<16"]
CLUSTER = ["dask>=2024.5,<2027", "distributed>=2024.5,<2027"]


def config_files():
    """Shipped YAML, CSV, schema and policy files, each to the folder of the same name below share/haul_ros."""
    folders = {}
    for path in sorted((HERE / "config").rglob("*")):
        if path.suffix in (".yaml", ".csv", ".json", ".xml"):
            relative = path.relative_to(HERE)
            folders.setdefault(f"{SHARE}/{relative.parent}", []).append(str(relative))
    return list(folders.items())


setup(
    name=NAME,
    version=VERSION,
    description="Longitudinal dynamics of heavy-haul trains in real time, for ROS 2",
    long_description=(HERE / "README.md").read_text(encoding="utf-8"),
    long_description_content_type="text/markdown",
    maintainer="haul_ros maintainers",
    maintainer_email="maintainers@haul-ros.example",
    license="Apache-2.0",
    packages=find_packages(include=[NAME, f"{NAME}.*"]),
    package_data={NAME: ["py.typed"], f"{NAME}.page": ["static/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (SHARE, ["package.xml"]),
        (f"{SHARE}/launch", ["launch/train.launch.py", "launch/trains.launch.py"]),
        *config_files(),
    ],
    python_requires=">=3.11",
    # Lower bounds are what Ubuntu 24.04 has, or the first that can do what is needed: scripts/oldest.txt.
    install_requires=[
        "numpy>=1.26,<3",
        "numba>=0.59,<1",
        "mcap>=1.6,<2",
        "lz4>=4.0,<5",  # the two that mcap compresses with: their heads are read before they decompress
        "zstandard>=0.22,<1",
        "rosbags>=0.11,<0.12",
        "ruamel.yaml>=0.17.21,<0.20",
        "jsonschema>=4.10,<5",
        "matplotlib>=3.7,<4",
        "tqdm>=4.64,<5",
    ],
    extras_require={
        # The real rclpy, for machines without a ROS installation (Linux x86_64, Python 3.11 to 3.13).
        "ros": ["ros-jazzy-rclpy[fastrtps]>=7.1,<8", "ros-jazzy-common-interfaces>=5.3,<6"],
        "parquet": PARQUET,
        "fatigue": FATIGUE,
        "studies": PARQUET,
        "cluster": CLUSTER,
        "view": VIEW,
        "test": [
            *VIEW,
            *PARQUET,
            *FATIGUE,
            *CLUSTER,
            "pytest>=8,<9.2",  # with 9.2 pytest-xdist 3.8 takes no notice of groups: files would be torn apart
            "pytest-cov>=7,<8",
            "pytest-xdist>=3.6,<4",
            "hypothesis>=6.100,<7",
            "scipy>=1.11,<2",
            "mcap-ros2-support>=0.5.5,<1",
            "playwright>=1.45,<2",
            "ruff==0.17.*",
            "mypy==2.4.*",
            "import-linter==2.*",
            "colcon-common-extensions>=0.3,<0.4",
            # the pages; rosdoc2 brings the same three
            "sphinx>=7.2,<9",
            "myst-parser>=3,<5",
            "sphinx-rtd-theme>=2,<4",
        ],
    },
    entry_points={
        "console_scripts": [
            "haul = haul_ros.cli.main:main",
            "train_node = haul_ros.ros.node:main",
        ],
    },
    zip_safe=False,
)
