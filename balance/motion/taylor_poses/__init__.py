"""Taylor motions put to use: poses that they foretell, their error, and the momentum."""
