"""Navigation to a goal: global planning, path tracking, local costmap, recovery.

A functional core on arrays. Poses are (x, y, heading) in m and rad. Global maps, goals, paths and zones are in ``map``,
the robot's surroundings in ``odom`` (thesis 4.2.2, Plan & Follow Path).
"""
