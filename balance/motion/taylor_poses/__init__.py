"""Taylor motions put to use: poses that they predict, their error, and the momentum."""
