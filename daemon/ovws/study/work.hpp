/// A study as a list of independent items, so that several machines can share it, and the table of
/// their results, from which its summary and figures are made.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
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

/// Rows of a table: objects with the same keys. Null: there is no such value. NaN: it is not known.
using Rows = std::vector<nlohmann::json>;

/// The rows that have all these values.
Rows rows_with(const Rows& rows, const nlohmann::json& values);
/// Appends a point for each row that has a value in column `y`, with its standard error if a column
/// of it is named. NaN makes a gap.
Series series_of(Series series, const Rows& rows, const char* x, const char* y,
                 const char* error = nullptr);

/// A study with one item for each row of its table.
struct Table {
  nlohmann::json head;  ///< of the summary, beside the rows
  Rows conditions;      ///< columns that say what is measured
  /// Measures the other columns of a row, see Work::measure.
  std::function<nlohmann::json(std::size_t)> measure;
  /// Adds the figures to the findings, which have the summary with its rows.
  std::function<void(const Rows&, Findings&)> draw;
};
/// The rows of conditions with the results of their items.
Rows rows_of(const Rows& conditions, const std::vector<nlohmann::json>& results);
Work work_of(Table table);

/// Measures these items on `threads` threads and returns the text of each result. `what`: the name
/// on the progress bar.
std::vector<std::string> measure_items(const Work& work, const std::string& what,
                                       const std::vector<std::size_t>& items, int threads);

}  // namespace ovws::study
