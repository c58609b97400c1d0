"""`python -m mjsim.cli`: the command line without its installed script."""

from mjsim.cli.program import main

if __name__ == "__main__":
    main()
