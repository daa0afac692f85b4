/// Marks what runs on the frame path: no lock, no allocation, no call that can block.
#pragma once

// Checked by the compiler where it can be (clang 20 and later); everywhere else by the allocation
// guard of tests/support, which fails a test on any allocation in such a call.
#if defined(__clang__) && __clang_major__ >= 20
#define OVWS_NONBLOCKING [[clang::nonblocking]]
#else
#define OVWS_NONBLOCKING
#endif
