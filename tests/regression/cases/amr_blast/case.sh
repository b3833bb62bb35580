# The blast on an adaptive grid of three levels, through several regrids.
program=amr_blast
arguments=(--coarsest 2 --finest 4 --cycles 40 --library-threads 2 --quiet)
# Where jumps come close to the shares that refine, last digits may choose another grid; so far they have not.
tolerances=(--tolerance-relative 1e-8 --tolerance-absolute 1e-10
            --max-pixel 2 --max-share 0.002 --min-similarity 0.99
            --ignore-column seconds --ignore-column bytes --ignore-column located_by_reason
            --ignore-column commits) # when to rebuild is decided by measured times
