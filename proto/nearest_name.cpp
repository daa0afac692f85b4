/// Suggests a known name for a misspelt one.
#include <algorithm>
#include <cctype>

#include "proto/reader.hpp"

namespace ovws {
namespace {

constexpr std::size_t kMaxNameLength = 64;  // longer names are not typing errors

char lower(char c) {
  return char(std::tolower(static_cast<unsigned char>(c)));
}

/// Damerau-Levenshtein distance (optimal string alignment), ignoring case.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t k = 0; k <= b.size(); ++k) last[k] = k;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t k = 1; k <= b.size(); ++k) {
      const bool same = lower(a[i - 1]) == lower(b[k - 1]);
      row[k] = std::min({last[k] + 1, row[k - 1] + 1, last[k - 1] + (same ? 0 : 1)});
      const bool swapped = i > 1 && k > 1 && lower(a[i - 1]) == lower(b[k - 2]) &&
                           lower(a[i - 2]) == lower(b[k - 1]);
      if (swapped) row[k] = std::min(row[k], before[k - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

/// Whether `name` is a prefix of `known`, ignoring case: "gain" instead of "gain_db".
bool is_prefix_of(std::string_view name, std::string_view known) {
  return name.size() >= 3 && known.size() > name.size() &&
         edit_distance(name, known.substr(0, name.size())) == 0;
}

}  // namespace

std::optional<std::string> nearest_name(std::string_view name,
                                        const std::vector<std::string>& known) {
  if (name.size() > kMaxNameLength) return std::nullopt;
  std::optional<std::string> nearest;
  std::size_t best = kMaxNameLength;
  for (const auto& candidate : known) {
    const std::size_t edits = edit_distance(name, candidate);
    const bool is_prefix = is_prefix_of(name, candidate);
    const std::size_t distance = is_prefix ? 1 : edits;
    // About one edit in three letters: "di" suggests "id", but "x" never suggests "y".
    const std::size_t allowed = (std::max(name.size(), candidate.size()) + 1) / 3;
    if (distance <= allowed && distance < best) {
      best = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

}  // namespace ovws
