"""Pictures and films of the world; what can be asked for is known without loading OpenGL."""

CAMERAS = ("front", "close", "above", "side", "person", "room")

#: A camera of films that moves: it keeps the sleeve in view, from where the robot hides it least.
AUTO = "auto"

#: What can be drawn besides what is there.
OVERLAYS = ("frames", "path", "demonstrations", "strain", "forces")

#: Software OpenGL draws no larger pictures [pixels].
LARGEST_SIDE = 4096

#: No film has more pictures a second: that is what the physics step gives.
LARGEST_FPS = 100
