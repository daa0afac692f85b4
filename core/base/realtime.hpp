/// OVWS_NONBLOCKING marks real-time functions: no lock, no allocation, no call that can block.
#pragma once

// clang 20 and later enforce it. With other compilers the allocation guard of tests/support fails a
// test on any allocation in such a call.
#if defined(__clang__) && __clang_major__ >= 20
#define OVWS_NONBLOCKING [[clang::nonblocking]]
#else
#define OVWS_NONBLOCKING
#endif
