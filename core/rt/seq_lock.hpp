/// Sequence lock (seqlock): publishes one value as a whole from one writer to any reader threads.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "core/base/realtime.hpp"

namespace ovws {

/// Value of one writer thread, for any number of reader threads. A reader never sees parts of two
/// values. RT-safe for the writer, which never waits; a reader repeats its copy while the writer
/// writes.
template <class T>
class SeqLock {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  explicit SeqLock(const T& initial = {}) { write(initial); }

  /// Writer thread: replaces the value.
  void write(const T& value) OVWS_NONBLOCKING {
    std::array<std::uint64_t, kWords> words{};
    std::memcpy(words.data(), &value, sizeof(T));
    const std::uint64_t before = sequence_.load(std::memory_order_relaxed);
    sequence_.store(before + 1, std::memory_order_relaxed);  // odd: a write is in progress
    // A reader that sees one of these words also sees the odd number.
    for (std::size_t k = 0; k < kWords; ++k) words_[k].store(words[k], std::memory_order_release);
    sequence_.store(before + 2, std::memory_order_release);
  }

  /// Any thread: the newest value.
  T read() const {
    std::array<std::uint64_t, kWords> words{};
    std::uint64_t before = 0, after = 1;
    while (before != after || before % 2 != 0) {
      before = sequence_.load(std::memory_order_acquire);
      for (std::size_t k = 0; k < kWords; ++k) words[k] = words_[k].load(std::memory_order_acquire);
      after = sequence_.load(std::memory_order_relaxed);
    }
    T value;
    std::memcpy(static_cast<void*>(&value), words.data(), sizeof(T));
    return value;
  }

 private:
  static constexpr std::size_t kWords =
      (sizeof(T) + sizeof(std::uint64_t) - 1) / sizeof(std::uint64_t);
  std::atomic<std::uint64_t> sequence_{0};
  std::array<std::atomic<std::uint64_t>, kWords> words_{};
};

}  // namespace ovws
