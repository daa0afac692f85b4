#include "daemon/shared/lost_spots.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "proto/json_text.hpp"
#include "proto/spot_rows.hpp"

namespace ovws::cli {

using nlohmann::json;

void SpotCounts::add(const StreamMessage& message) {
  if (!json_of(message.json).at("settled").get<bool>()) return;
  const std::vector<SpotRow> rows = spot_rows(message.binary);
  if (rows.size() != found.size()) *this = {0, std::vector<int>(rows.size())};
  ++frames;
  for (std::size_t k = 0; k < rows.size(); ++k) found[k] += std::isnan(rows[k].x) ? 0 : 1;
}

std::vector<int> SpotCounts::lost(double share) const {
  std::vector<int> numbers;
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (found[k] < share * frames) numbers.push_back(int(k));
  }
  return numbers;
}

std::vector<int> lost_in_reference(const json& reference) {
  std::vector<int> numbers;
  if (!reference.is_object()) return numbers;
  const json errors = reference.value("standard_error_px", json());
  if (reference.value("source", json()) != "measured" || !errors.is_array()) return numbers;
  for (std::size_t k = 0; k < errors.size(); ++k) {
    const json& error = errors[k];
    const bool is_known = error.is_array() && !error.empty() && error[0].is_number();
    if (!is_known) numbers.push_back(int(k));
  }
  return numbers;
}

std::string placed_spots(const std::vector<int>& spots, const json& reference) {
  constexpr std::size_t kNamed = 8;
  const json places = reference.is_object() ? reference.value("positions_px", json()) : json();
  std::string text;
  for (std::size_t k = 0; k < std::min(kNamed, spots.size()); ++k) {
    const auto spot = std::size_t(spots[k]);
    text += fmt::format("{}{}", k == 0 ? "" : ", ", spot);
    if (!places.is_array() || spot >= places.size() || !places[spot].is_array()) continue;
    const json& place = places[spot];
    if (!place.at(0).is_number() || !place.at(1).is_number()) continue;
    text += fmt::format(" at ({:.0f}, {:.0f}) px", place[0].get<double>(), place[1].get<double>());
  }
  if (spots.size() > kNamed) text += fmt::format(" and {} more", spots.size() - kNamed);
  return text;
}

}  // namespace ovws::cli
