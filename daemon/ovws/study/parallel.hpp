/// Parallel loop with a progress bar, and the line that shows progress.
#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace ovws::study {

/// Replaces the progress line on standard error; an empty `text` removes it. Prints nothing if
/// standard error is not a terminal.
void print_progress(std::string_view text);

/// The number of hardware threads; at least 1.
int all_cores();

/// Calls `work(i)` once for each i below `count` on `threads` threads, the caller's included.
/// Rethrows an exception of `work` after all threads have ended.
void parallel_for(const std::string& what, std::size_t count, int threads,
                  const std::function<void(std::size_t)>& work);

}  // namespace ovws::study
