"""What turns a recording into numbers: forces, friction, releases, each with what it leaves uncertain."""
