#include "tests/support/alloc_guard.hpp"

#include <cerrno>
#include <cstddef>

// Interposes malloc, which counts operator new and Eigen's aligned allocations too.

namespace {
// Plain data with constant initialisation: reading it never allocates.
thread_local std::uint64_t allocations_of_this_thread = 0;
}  // namespace

// GCC reports sanitizers by a macro, Clang by __has_feature.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define OVWS_SANITIZED 1
#elif defined(__has_feature)
#define OVWS_SANITIZED (__has_feature(address_sanitizer) || __has_feature(thread_sanitizer))
#else
#define OVWS_SANITIZED 0
#endif

#if OVWS_SANITIZED

extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*on_malloc)(const volatile void*,
                                                                           std::size_t),
                                                         void (*on_free)(const volatile void*));
namespace {
void count_malloc(const volatile void*, std::size_t) {
  ++allocations_of_this_thread;
}
void ignore_free(const volatile void*) {}
[[maybe_unused]] const int installed =
    __sanitizer_install_malloc_and_free_hooks(count_malloc, ignore_free);
}  // namespace

#else

extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) {
  ++allocations_of_this_thread;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++allocations_of_this_thread;
  return __libc_calloc(count, size);
}
void* realloc(void* memory, std::size_t size) {
  ++allocations_of_this_thread;
  return __libc_realloc(memory, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++allocations_of_this_thread;
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
  ++allocations_of_this_thread;
  *memory = __libc_memalign(alignment, size);
  return *memory == nullptr ? ENOMEM : 0;
}
}  // extern "C"

#endif

namespace ovws::test {

AllocGuard::AllocGuard() : before_(allocations_of_this_thread) {}

std::uint64_t AllocGuard::allocations() const {
  return allocations_of_this_thread - before_;
}

}  // namespace ovws::test
