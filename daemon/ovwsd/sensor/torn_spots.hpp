/// Spots that no ordinary tracker follows, because the wavefront has torn them.
#pragma once

#include <memory>
#include <vector>

#include "core/base/vec2.hpp"
#include "core/tracking/template_bank.hpp"

namespace ovws {

struct TornSpots {
  std::vector<Vec2> at_px;  ///< of every spot, torn or not, camera pixels
  /// What a torn spot is followed by; null for the others.
  std::vector<std::shared_ptr<const TemplateBank>> templates;

  std::vector<int> numbers() const {
    std::vector<int> out;
    for (std::size_t i = 0; i < templates.size(); ++i) {
      if (templates[i]) out.push_back(int(i));
    }
    return out;
  }
};

}  // namespace ovws
