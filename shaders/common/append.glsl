// Room in a list of rays for `count` more, written by one invocation of a group: the first free place goes to `first`,
// and the indirect arguments (groups of 64 in rows, then the count) grow.
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
