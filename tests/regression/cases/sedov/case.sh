# The blast wave on 12^3 cells, until the shock is halfway.
program=sedov
arguments=(--cells 12 --cycles 40 --library-threads 2 --quiet)
# Enough for what compilers and their mathematical functions do to the last digits in 40 cycles;
# cells, endings and counts are whole numbers or words, and have to be equal.
tolerances=(--tolerance-relative 1e-9 --tolerance-absolute 1e-11
            --max-pixel 2 --max-share 0.002 --min-similarity 0.99
            --ignore-column seconds --ignore-column bytes --ignore-column located_by_reason
            --ignore-column commits) # when to rebuild is decided by measured times
