"""The registrations of amorsim itself, through the hook that every plugin uses.

Components are named, not imported: each is imported at its first use.
"""

from __future__ import annotations

from pathlib import Path

from amorsim.plugins.hooks import hookimpl
from amorsim.plugins.registry import Registry

__all__ = ["amorsim_register"]

_PACKAGE = Path(__file__).parents[1]


@hookimpl
def amorsim_register(registry: Registry) -> None:
    """Register the built-in components, robots and scenarios."""
    registry.drive("differential", "amorsim.drives.differential:Differential")
    registry.drive("ackermann", "amorsim.drives.ackermann:Ackermann")
    registry.drive("synchro", "amorsim.drives.synchro:Synchro")
    registry.drive("tricycle", "amorsim.drives.tricycle:Tricycle")
    registry.drive("mecanum", "amorsim.drives.mecanum:Mecanum")
    registry.drive("tractor", "amorsim.drives.tractor:Tractor")

    registry.sensor("encoder", "amorsim.sensors.encoder:Encoder")
    registry.sensor("laser", "amorsim.sensors.laser:Laser")
    registry.sensor("sonar", "amorsim.sensors.sonar:Sonar")
    registry.sensor("compass", "amorsim.sensors.compass:Compass")
    registry.sensor("gyro", "amorsim.sensors.gyro:Gyro")
    registry.sensor("bumper", "amorsim.sensors.bumper:Bumper")
    registry.sensor("camera", "amorsim.sensors.camera:Camera")
    registry.sensor("fiducial", "amorsim.sensors.fiducial:Fiducial")
    registry.sensor("gps", "amorsim.sensors.gps:Gps")
    registry.sensor("imu", "amorsim.sensors.imu:Imu")
    registry.sensor("infrared", "amorsim.sensors.infrared:Infrared")
    registry.sensor("light", "amorsim.sensors.light:Light")
    registry.sensor("line", "amorsim.sensors.line:Line")
    registry.sensor("neighbours", "amorsim.sensors.neighbours:Neighbours")
    registry.sensor("cliff", "amorsim.sensors.cliff:Cliff")

    registry.noise("gaussian", "amorsim.noise.gaussian:Gaussian")
    registry.noise("aim_gaussian", "amorsim.noise.aim_gaussian:AimGaussian")
    registry.noise("bias", "amorsim.noise.bias:Bias")
    registry.noise("scale", "amorsim.noise.scale:Scale")
    registry.noise("quantize", "amorsim.noise.quantize:Quantize")
    registry.noise("saturate", "amorsim.noise.saturate:Saturate")
    registry.noise("noise_floor", "amorsim.noise.noise_floor:NoiseFloor")
    registry.noise("dropout", "amorsim.noise.dropout:Dropout")
    registry.noise("missed", "amorsim.noise.missed:Missed")
    registry.noise("outliers", "amorsim.noise.outliers:Outliers")
    registry.noise("stuck", "amorsim.noise.stuck:Stuck")
    registry.noise("angle_random_walk", "amorsim.noise.angle_random_walk:AngleRandomWalk")
    registry.noise("bias_instability", "amorsim.noise.bias_instability:BiasInstability")
    registry.noise("bias_random_walk", "amorsim.noise.bias_random_walk:BiasRandomWalk")
    registry.noise("compass_deviation", "amorsim.noise.compass_deviation:CompassDeviation")
    registry.noise("beam_model", "amorsim.noise.beam_model:BeamModel")
    registry.noise("specular_loss", "amorsim.noise.specular_loss:SpecularLoss")
    registry.noise("cross_talk", "amorsim.noise.cross_talk:CrossTalk")
    registry.noise("motion_distortion", "amorsim.noise.motion_distortion:MotionDistortion")
    registry.noise("latency_jitter", "amorsim.noise.latency_jitter:LatencyJitter")
    registry.noise("diffusion", "amorsim.noise.diffusion:Diffusion")
    registry.noise("velocity_model", "amorsim.noise.velocity_model:VelocityModel")
    registry.noise("odometry_model", "amorsim.noise.odometry_model:OdometryModel")
    registry.noise("slip", "amorsim.noise.slip:Slip")
    registry.noise("bump", "amorsim.noise.bump:Bump")

    registry.map_loader("wld", "amorsim.maps.wld:Wld")
    registry.map_loader("bmp", "amorsim.maps.bmp:Bitmap")
    registry.map_loader("ros", "amorsim.maps.ros:Ros")
    registry.map_loader("movingai", "amorsim.maps.movingai:MovingAI")
    registry.map_loader("geojson", "amorsim.maps.geojson:GeoJson")
    registry.map_loader("svg", "amorsim.maps.svg:Svg")
    registry.map_loader("dxf", "amorsim.maps.dxf:Dxf")
    registry.map_loader("maz", "amorsim.maps.maz:Maz")
    registry.map_loader("stage", "amorsim.foreign.stage.map:StageMap")
    registry.map_loader("mobilesim", "amorsim.foreign.mobilesim:MobileSimMap")
    registry.map_loader("khepera", "amorsim.foreign.khepera:KheperaMap")

    registry.scenario_loader("stage", "amorsim.foreign.stage.loader:Stage")
    registry.scenario_loader("mobilesim", "amorsim.foreign.mobilesim:MobileSim")
    registry.scenario_loader("khepera", "amorsim.foreign.khepera:Khepera")

    registry.world_generator("office", "amorsim.worlds.offices:Office")
    registry.world_generator("maze", "amorsim.worlds.mazes:Maze")
    registry.world_generator("cave", "amorsim.worlds.caves:Cave")
    registry.world_generator("forest", "amorsim.worlds.forests:Forest")
    registry.world_generator("warehouse", "amorsim.worlds.warehouses:Warehouse")
    registry.world_generator("crossing", "amorsim.worlds.crossings:Crossing")
    registry.world_generator("barn", "amorsim.worlds.barn_fields:Barn")

    registry.motion("waypoints", "amorsim.motions.routes:Waypoints")
    registry.motion("loop", "amorsim.motions.routes:Loop")
    registry.motion("oscillate", "amorsim.motions.routes:Oscillate")
    registry.motion("wander", "amorsim.motions.wander:Wander")
    registry.motion("track", "amorsim.motions.track:Track")
    registry.motion("pedestrian", "amorsim.motions.pedestrian:Pedestrian")
    registry.motion("swing_door", "amorsim.motions.doors:SwingDoor")
    registry.motion("sliding_door", "amorsim.motions.doors:SlidingDoor")

    registry.estimator("dead_reckoning", "amorsim.estimators.dead_reckoning:DeadReckoning")
    registry.estimator("ekf", "amorsim.estimators.ekf:Ekf")
    registry.estimator("ukf", "amorsim.estimators.ukf:Ukf")
    registry.estimator("monte_carlo", "amorsim.estimators.monte_carlo:MonteCarlo")
    registry.estimator("grid_mapping", "amorsim.estimators.grid_mapping:GridMapping")
    registry.estimator("graph_slam", "amorsim.estimators.graph_slam:GraphSlam")
    registry.estimator("grid_slam", "amorsim.estimators.grid_slam:GridSlam")
    registry.estimator("scan_matching", "amorsim.estimators.scan_matching:ScanMatching")

    registry.controller("wander", "amorsim.controllers.wander:Wander")
    registry.controller("goto", "amorsim.controllers.goto:GoTo")
    registry.controller("square", "amorsim.controllers.square:Square")
    registry.controller("manual", "amorsim.controllers.manual:Manual")
    registry.controller("pursuit", "amorsim.controllers.pursuit:Pursuit")
    registry.controller("follow", "amorsim.controllers.follow:Follow")
    registry.controller("braitenberg", "amorsim.controllers.braitenberg:Braitenberg")
    registry.controller("dwa", "amorsim.controllers.dwa:Dwa")
    registry.controller("vfh_plus", "amorsim.controllers.headed:VfhPlus")
    registry.controller("potential_field", "amorsim.controllers.headed:PotentialField")
    registry.controller("path_pursuit", "amorsim.controllers.path_pursuit:PathPursuit")
    registry.controller("mppi", "amorsim.controllers.mppi:Mppi")
    registry.controller("nearness_diagram", "amorsim.controllers.bugs:NearnessDiagram")
    registry.controller("bug2", "amorsim.controllers.bugs:Bug2")
    registry.controller("tangent_bug", "amorsim.controllers.bugs:TangentBug")
    registry.controller("orca", "amorsim.controllers.among:Orca")
    registry.controller("hrvo", "amorsim.controllers.among:Hrvo")
    registry.controller("social_force", "amorsim.controllers.among:SocialForce")
    registry.controller("human_like", "amorsim.controllers.among:HumanLike")
    registry.controller("navigate", "amorsim.controllers.navigate:Navigate")
    registry.controller("follow_wall", "amorsim.controllers.wall:FollowWall")
    registry.controller("policy", "amorsim.controllers.policy:Policy")

    registry.planner("dijkstra", "amorsim.planners.dijkstra:Dijkstra")
    registry.planner("a_star", "amorsim.planners.a_star:AStar")
    registry.planner("wavefront", "amorsim.planners.wavefront:Wavefront")
    registry.planner("jump_point", "amorsim.planners.jump_point:JumpPoint")
    registry.planner("d_star_lite", "amorsim.planners.d_star_lite:DStarLite")
    registry.planner("theta_star", "amorsim.planners.theta_star:ThetaStar")
    registry.planner("voronoi", "amorsim.planners.voronoi:Voronoi")
    registry.planner("potential_field", "amorsim.planners.potential_field:PotentialField")
    registry.planner("rrt", "amorsim.planners.trees:Rrt")
    registry.planner("rrt_connect", "amorsim.planners.trees:RrtConnect")
    registry.planner("rrt_star", "amorsim.planners.trees:RrtStar")
    registry.planner("prm", "amorsim.planners.prm:Prm")
    registry.planner("dubins", "amorsim.planners.curve_planner:Dubins")
    registry.planner("reeds_shepp", "amorsim.planners.curve_planner:ReedsShepp")
    registry.planner("hybrid_a_star", "amorsim.planners.hybrid_a_star:HybridAStar")

    registry.recorder("text", "amorsim.recorders.text:Text")
    registry.recorder("arrays", "amorsim.recorders.arrays:Arrays")

    registry.metric("position_error", "amorsim.metrics.errors:PositionError")
    registry.metric("heading_error", "amorsim.metrics.errors:HeadingError")
    registry.metric("recovery_time", "amorsim.metrics.errors:RecoveryTime")
    registry.metric("nees", "amorsim.metrics.consistency:Nees")
    registry.metric("nis", "amorsim.metrics.consistency:Nis")
    registry.metric("path_length", "amorsim.metrics.driving:PathLength")
    registry.metric("turning", "amorsim.metrics.driving:Turning")
    registry.metric("arrival_time", "amorsim.metrics.driving:ArrivalTime")
    registry.metric("collisions", "amorsim.metrics.driving:Collisions")
    registry.metric("success", "amorsim.metrics.driving:Success")
    registry.metric("spl", "amorsim.metrics.driving:Spl")
    registry.metric("clearance", "amorsim.metrics.space:Clearance")
    registry.metric("coverage", "amorsim.metrics.space:Coverage")
    registry.metric("map_accuracy", "amorsim.metrics.mapping:MapAccuracy")
    registry.metric("map_completeness", "amorsim.metrics.mapping:MapCompleteness")
    registry.metric("map_iou", "amorsim.metrics.mapping:MapIou")

    registry.task("point_goal", "amorsim.tasks.point_goal:PointGoal")
    registry.task("follow_leader", "amorsim.tasks.follow_leader:FollowLeader")
    registry.task("follow_line", "amorsim.tasks.follow_line:FollowLine")
    registry.task("park", "amorsim.tasks.park:Park")

    for name in ("sick-lms200", "polaroid-600", "tcm2", "adxrs300"):
        registry.device(name, _PACKAGE / "devices" / f"{name}.toml")
    for robot in (
        "pioneer2dx",
        "pioneer2dx-typical",
        "pioneer2dx-lms200",
        "pioneer3dx",
        "khepera",
        "segway_rmp",
        "b21r",
        "nomad200",
        "car",
        "turtlebot3_burger",
        "youbot",
        "jackal",
    ):
        registry.robot(robot, _PACKAGE / "robots" / f"{robot}.toml")
    for scenario in (
        *(
            "demo",
            "car-park",
            "synchro-hall",
            "khepera-maze",
            "line",
            "convoy",
            "yard",
            "crowd",
            "doors",
            "swarm",
            "landmarks",
            "find-yourself",
            "kidnapped",
            "loop",
            "map-the-office",
            "find-the-way",
            "parking-lot",
            "unknown-maze",
            "learned",
            "crossing",
        ),
    ):
        registry.scenario(scenario, _PACKAGE / "scenarios" / f"{scenario}.toml")
