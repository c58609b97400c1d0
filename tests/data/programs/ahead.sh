#!/bin/sh
# A navigator in plain shell: straight on, until something is nearer than half a metre; then it turns.
while read -r line; do
    case $line in
        '{"call":"start"'*) echo '{}' ;;
        *)
            # The first of the 16 ranges looks ahead; null is infinity.
            ahead=${line#*'"proximity":['}
            ahead=${ahead%%,*}
            case $ahead in
                0 | 0.[0-4]*) echo '{"turn": 0.5}' ;;
                *) echo '{"forward": 0.3}' ;;
            esac
            ;;
    esac
done
