/// Split spots, which a strong aberration has split into fragments and ordinary trackers lose.
#pragma once

#include <memory>
#include <vector>

#include "core/base/vec2.hpp"
#include "core/tracking/template_bank.hpp"

namespace ovws {

struct SplitSpots {
  std::vector<Vec2> at_px;  ///< positions of all spots, split or not, camera pixels
  /// Template of each split spot; null for the others. May be empty: no spot is split.
  std::vector<std::shared_ptr<const TemplateBank>> templates;

  /// Indices of the split spots.
  std::vector<int> numbers() const {
    std::vector<int> out;
    for (std::size_t i = 0; i < templates.size(); ++i) {
      if (templates[i]) out.push_back(int(i));
    }
    return out;
  }
};

}  // namespace ovws
