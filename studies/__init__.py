"""One script per question: the paper's figures, and how accurate, fast and complete results are.

Each study is a module of this folder, which is not installed; it runs from the folder above::

    python -m studies.figures.fig08_return_map [--fast] [--out DIR]

Its ``main(fast, out)`` returns the numbers that it prints. :mod:`studies.run_all` runs all studies
and keeps their numbers and pictures in ``results/``; :mod:`studies.readme` fills a page from them.
Folders import only from folders above them; scripts beside the folders import from any. Folders:

``common/``
    shared by the studies: command line, clocks, style of pictures, both laws, the paper's motion
    and places, exact maps, random toys, checks of diagrams
``peers/``
    other ways to follow the toy, and the scenes with 30-digit references that measure them
``failures/``
    where methods fail, the project's own among them
``precision/``
    what a digit costs with each method
``reductions/``
    what each reduction of the problem saves
``figures/``
    the paper's Figures 4 to 12
``maps/``
    three maps of the literature
``systems/``
    systems with contacts against closed forms and peers, and random systems
``exact/``
    what exact maps cost: composition, cycles of high order, crises, entropy, certificates
``data/``
    numbers read off the paper's figures

Scripts beside the folders:

``jump_crossing``
    what a jump crossing is, in one picture
``main_job``
    the branches that are connected with the stable motion
``two_parameters``, ``regions``
    special points over two parameters, and which cycles exist where between their curves
``robustness``
    how far the stable motion is from its end
``proofs``
    what is proved of the toy, how wide the enclosures are, and what they cost
``paper_numbers``
    every number the paper prints, beside the model's
``sensitivities``
    why the paper's period is shorter
``order_three``
    the whole diagram with period 3, beyond the paper
``completeness``
    whether diagrams are complete and free of duplicates: random toys against plain tabulation
``mechanisms``
    what diagrams lose without each mechanism of the continuation engine
``benchmark``
    how fast and how accurate a return is
"""
