/// A study as a list of independent items, so that several machines can share it.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "daemon/ovws/study/figure.hpp"

namespace ovws::study {

/// The results of a study. A study that cannot run is a bug and throws.
struct Findings {
  nlohmann::json summary;  ///< machine-readable; the same whatever the machine and its threads
  std::vector<Figure> figures;
};

/// The items of a study. A random number stream belongs to one item, so that an item gives the same
/// result whoever measures it, and in whatever order.
struct Work {
  std::size_t items = 0;
  /// Measures one item. Thread-safe.
  std::function<nlohmann::json(std::size_t)> measure;
  /// Makes figures and summary from the results of all items, in their order.
  std::function<Findings(const std::vector<nlohmann::json>&)> find;
};

/// Result of an item as text (JSON): each number in the shortest form that reads back the same, NaN
/// and infinity as "nan", "inf" and "-inf". A result must not contain other text.
std::string result_text(nlohmann::json result);
/// Restores a result from its text. Throws nlohmann::json::exception if the text is not JSON.
nlohmann::json result_of(const std::string& text);

/// Work whose items have results of the type that `measure` returns. `measure(k)` is called for the
/// items below `items`, and `find(results)` with their results. Both own what they use.
template <class Measure, class Find>
Work work_of(std::size_t items, Measure measure, Find find) {
  using One = std::invoke_result_t<Measure, std::size_t>;
  return {items,
          [measure = std::move(measure)](std::size_t k) { return nlohmann::json(measure(k)); },
          [find = std::move(find)](const std::vector<nlohmann::json>& results) {
            std::vector<One> typed;
            for (const nlohmann::json& result : results) typed.push_back(result.get<One>());
            return find(typed);
          }};
}

/// Measures these items on `threads` threads and returns the text of each result. `what`: the name
/// on the progress bar.
std::vector<std::string> measure_items(const Work& work, const std::string& what,
                                       const std::vector<std::size_t>& items, int threads);

}  // namespace ovws::study
