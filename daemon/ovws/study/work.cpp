#include "daemon/ovws/study/work.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "daemon/ovws/study/parallel.hpp"
#include "daemon/ovws/study/studies.hpp"

namespace ovws::study {
namespace {

using nlohmann::json;

/// Calls `change` for each value in `tree` that is neither array nor object.
template <class Change>
void each_leaf(json& tree, const Change& change) {
  if (!tree.is_structured()) return change(tree);
  for (json& inner : tree) each_leaf(inner, change);
}

void name_if_not_finite(json& leaf) {
  if (!leaf.is_number_float()) return;
  const double value = leaf.get<double>();
  if (std::isnan(value)) leaf = "nan";
  if (std::isinf(value)) leaf = value > 0.0 ? "inf" : "-inf";
}

void value_of_name(json& leaf) {
  if (!leaf.is_string()) return;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto& name = leaf.get_ref<const std::string&>();
  leaf = name == "inf"    ? kInfinity
         : name == "-inf" ? -kInfinity
                          : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

std::string result_text(json result) {
  each_leaf(result, name_if_not_finite);
  return result.dump();
}

json result_of(const std::string& text) {
  json result = json::parse(text);
  each_leaf(result, value_of_name);
  return result;
}

std::vector<std::string> measure_items(const Work& work, const std::string& what,
                                       const std::vector<std::size_t>& items, int threads) {
  std::vector<std::string> results(items.size());
  parallel_for(what, items.size(), threads,
               [&](std::size_t k) { results[k] = result_text(work.measure(items[k])); });
  return results;
}

Rows rows_with(const Rows& rows, const json& values) {
  const auto has_all = [&values](const json& row) {
    for (const auto& [key, value] : values.items()) {
      if (row.at(key) != value) return false;
    }
    return true;
  };
  Rows found;
  std::ranges::copy_if(rows, std::back_inserter(found), has_all);
  return found;
}

Series series_of(Series series, const Rows& rows, const char* x, const char* y, const char* error) {
  for (const json& row : rows) {
    if (row.at(y).is_null()) continue;
    series.add(row.at(x).get<double>(), row.at(y).get<double>());
    if (error != nullptr) series.error.push_back(row.at(error).get<double>());
  }
  return series;
}

Rows rows_of(const Rows& conditions, const std::vector<json>& results) {
  Rows rows = conditions;
  for (std::size_t k = 0; k < rows.size(); ++k) rows[k].update(results[k]);
  return rows;
}

Work work_of(Table table) {
  const std::size_t items = table.conditions.size();
  auto measure = table.measure;
  return {items, std::move(measure), [table = std::move(table)](const std::vector<json>& results) {
            const Rows rows = rows_of(table.conditions, results);
            Findings found{table.head, {}};
            found.summary["rows"] = rows;
            table.draw(rows, found);
            return found;
          }};
}

const Study* study_named(std::string_view name) {
  const auto* const found = std::find_if(kStudies.begin(), kStudies.end(),
                                         [name](const Study& one) { return one.name == name; });
  return found == kStudies.end() ? nullptr : found;
}

}  // namespace ovws::study
