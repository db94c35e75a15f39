"""Convert SDF files of Gazebo to the elements of URDF files with loops.

Joints of SDF form a graph, and poses a tree of frames. A spanning tree of the graph becomes the
joints of the URDF file, and every other joint a ``<loop>``.
"""
