"""The package for colcon; pianta itself comes from pip."""

from setuptools import setup

NAME = "pianta_ros"

setup(
    name=NAME,
    version="0.2.0",
    packages=[NAME],
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/launch", ["launch/rooms.launch.py"]),
    ],
    install_requires=["setuptools", "pianta>=0.2"],
    zip_safe=True,
    maintainer="The pianta authors",
    description="Rooms of the map of a robot, by pianta",
    license="Apache-2.0",
    entry_points={"console_scripts": [f"rooms = {NAME}.rooms_node:main"]},
)
