/// OVWS_NONBLOCKING marks real-time functions: no lock, no allocation, no call that can block.
#pragma once

// clang 20 and later check the attribute at compile time. With other compilers, the allocation
// guard in tests/support fails a test if a marked function allocates memory.
#if defined(__clang__) && __clang_major__ >= 20
#define OVWS_NONBLOCKING [[clang::nonblocking]]
#else
#define OVWS_NONBLOCKING
#endif
