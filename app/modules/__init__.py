"""The robot's modules: sensors, perception, behaviors, motivations and actuation, one a file.

They know messages, the runtime, attention's desires and the robot interface; not the web, nor which body they run on.
"""
