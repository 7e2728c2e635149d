"""Small plans as ground stations write them, and the patterns in them."""

import copy

HOME = [47.4, 8.55, 500.0]


def simple(command, *params, frame=3, **more):
    params = list(params) + [0] * (7 - len(params))
    if frame == 3 and not any(params[4:]):
        params[4:] = [47.4001, 8.5501, 20.0]
    item = {"type": "SimpleItem", "command": command, "frame": frame, "params": params, "autoContinue": True}
    return item | more


def plan_of(*items, fence=None, rally=(), firmware=12):
    return {
        "fileType": "Plan",
        "version": 1,
        "groundStation": "QGroundControl",
        "mission": {
            "version": 2,
            "firmwareType": firmware,
            "plannedHomePosition": HOME,
            "items": list(items),
        },
        "geoFence": fence or {"version": 2, "polygons": [], "circles": []},
        "rallyPoints": {"version": 2, "points": list(rally)},
    }


TAKEOFF, WAYPOINT, RETURN = simple(22, 0, 0, 0, None), simple(16, 0, 0, 0, None), simple(20, frame=2)
GOOD = plan_of(TAKEOFF, WAYPOINT, RETURN)
CAMERA = {
    "version": 2,
    "CameraName": "Manual (no camera specs)",
    "AdjustedFootprintSide": 25,
    "AdjustedFootprintFrontal": 25,
    "DistanceToSurface": 50,
    "DistanceMode": 1,
}
SPECS = {
    "CameraName": "Custom Camera",
    "ValueSetIsDistance": True,
    "ImageDensity": 1.4,
    "FrontalOverlap": 70,
    "SideOverlap": 70,
    "SensorWidth": 13.2,
    "SensorHeight": 8.8,
    "ImageWidth": 5472,
    "ImageHeight": 3648,
    "FocalLength": 8.8,
    "Landscape": True,
    "FixedOrientation": False,
    "MinTriggerInterval": 0.7,
}
TRANSECTS = {
    "version": 2,
    "TurnAroundDistance": 10,
    "CameraTriggerInTurnAround": True,
    "HoverAndCapture": False,
    "Refly90Degrees": False,
    "CameraCalc": CAMERA,
    "VisualTransectPoints": [],
    "Items": [WAYPOINT, simple(206, 20, 0, 1, frame=2)],
    "CameraShots": 3,
}
SURVEY = {
    "type": "ComplexItem",
    "complexItemType": "survey",
    "version": 5,
    "angle": 0,
    "polygon": [],
    "TransectStyleComplexItem": TRANSECTS,
}
STRUCTURE = {
    "type": "ComplexItem",
    "complexItemType": "StructureScan",
    "version": 3,
    "EntranceAltitude": 50,
    "ScanBottomAlt": 5,
    "StructureHeight": 30,
    "Layers": 3,
    "GimbalPitch": 0,
    "StartFromTop": False,
    "CameraCalc": CAMERA,
    "polygon": [[47.4, 8.55], [47.4, 8.551], [47.401, 8.55], [47.401, 8.551]],
}


def changed(**paths):
    """`GOOD` with the values at dotted paths replaced; `...` removes."""
    plan = copy.deepcopy(GOOD)
    for path, value in paths.items():
        *way, last = [int(step) if step.isdigit() else step for step in path.split("__")]
        holder = plan
        for step in way:
            holder = holder[step]
        if value is ...:
            del holder[last]
        else:
            holder[last] = value
    return plan
