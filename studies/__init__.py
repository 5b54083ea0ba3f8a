"""One script per question: the paper's figures, and how exact, how fast and how sound all this is.

Each is a module of this folder, which is not installed, and runs from the folder that holds it::

    python -m studies.figures.fig08_return_map [--fast] [--out DIR]

Its ``main(fast, out)`` returns the numbers that it prints. :mod:`studies.run_all` runs all of them
and keeps numbers and pictures in ``results/``, from which :mod:`studies.readme` fills its page.
Folders import what stands above them, and scripts beside the folders import any. In folders:

``common/``
    what studies share: command line, clocks, look of pictures, both laws, the paper's motion and
    places, random toys, checks of diagrams
``peers/``
    other ways to follow the toy, and the scenes with thirty digits that all are measured by
``failures/``
    where methods fail, the project's own among them
``precision/``
    what a digit costs, by every method
``reductions/``
    what each reduction of the problem buys
``figures/``
    the paper's Figures 4 to 12
``maps/``
    three maps of the literature
``systems/``
    systems of contacts, against closed forms and peers, and random ones
``exact/``
    what exact maps cost: composition, cycles of high order, crises, entropy, certificates
``data/``
    what was read off the paper's figures

and beside them:

``jump_crossing``
    what a jump crossing is, in one picture
``main_job``
    what is connected with the stable motion
``paper_numbers``
    every number the paper prints, beside the model's
``sensitivities``
    why the paper's period is shorter
``order_three``
    the whole diagram with period 3, beyond the paper
``completeness``
    whether diagrams have everything, and nothing twice: random toys against plain tabulation
``mechanisms``
    what the continuation engine is worth without each of its mechanisms
``benchmark``
    how fast and how exact a return is
"""
