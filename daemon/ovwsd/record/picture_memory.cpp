#include "daemon/ovwsd/record/picture_memory.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <new>
#include <thread>

namespace ovws {
namespace {

constexpr std::size_t kStepBytes = 1 << 20;
/// Lets page faults of other threads have the kernel's memory lock.
constexpr std::chrono::microseconds kPause(100);

}  // namespace

PictureMemory::PictureMemory(std::size_t bytes) : bytes_(bytes) {
  if (bytes == 0) return;
  constexpr int kPrivate = MAP_PRIVATE | MAP_ANONYMOUS;
  void* const room = ::mmap(nullptr, bytes, PROT_NONE, kPrivate | MAP_NORESERVE, -1, 0);
  if (room == MAP_FAILED) throw std::bad_alloc();
  begin_ = static_cast<std::byte*>(room);
  for (std::size_t at = 0; at < bytes; at += kStepBytes) {
    const std::size_t step = std::min(kStepBytes, bytes - at);
    void* const taken =
        ::mmap(begin_ + at, step, PROT_READ | PROT_WRITE, kPrivate | MAP_FIXED, -1, 0);
    if (taken == MAP_FAILED) {
      ::munmap(room, bytes);
      throw std::bad_alloc();
    }
    std::memset(taken, 0, step);  // touches the pages, also where memory is not locked
    std::this_thread::sleep_for(kPause);
  }
}

PictureMemory::~PictureMemory() {
  for (std::size_t at = 0; at < bytes_; at += kStepBytes) {
    ::munmap(begin_ + at, std::min(kStepBytes, bytes_ - at));
    std::this_thread::sleep_for(kPause);
  }
}

}  // namespace ovws
