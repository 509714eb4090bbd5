// Reserves room for `count` more entries in a list of rays. One invocation of a group calls it. `first` receives the index of
// the first reserved entry, and the indirect arguments (groups of 64 in rows, then the count) grow accordingly.
#ifndef APPEND_GLSL
#define APPEND_GLSL

#define MAKE_ROOM(list_arguments, count, first)                                                     \
    {                                                                                               \
        first = atomicAdd(list_arguments[3], count);                                                \
        uint groups = (first + count + 63u) / 64u;                                                  \
        atomicMax(list_arguments[0], min(groups, ROW_OF_GROUPS));                                   \
        atomicMax(list_arguments[1], (groups + ROW_OF_GROUPS - 1u) / ROW_OF_GROUPS);                \
    }

#endif
