"""The way to a goal: where the map lets the body go, how it gets there, and what stands around it just now.

A functional core on arrays. Poses are (x, y, heading) in m and rad. Global maps, goals, paths and zones are in ``map``,
what stands around the robot in ``odom`` (thesis 4.2.2, Plan & Follow Path).
"""
