/// The daemon's bench as the gain sweep uses it: shows an aberration with a charge, and takes
/// images at a gain.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "config/config.hpp"
#include "core/base/image.hpp"
#include "daemon/shared/borrow.hpp"
#include "proto/limits.hpp"

namespace ovws::cli {

/// Images of the camera, of one format.
struct GrabbedImages {
  std::vector<std::byte> pixels;
  std::vector<ImageView> views{};  ///< into `pixels`
  double gain_db = 0.0;            ///< as read back
};

/// Its functions throw CallFailed. Other clients may use the bench meanwhile: a grab fails if the
/// hologram is replaced.
class ExperimentBench {
 public:
  /// Reads the bench's state, which `restore_after` restores. Errors: the camera has no gain in dB;
  /// a DMD shows a sequence, which could not be restored.
  explicit ExperimentBench(const Common& common);

  /// The configuration in use, with the registration.
  const Config& config() const { return config_; }
  const Range<double>& gains_db() const { return gains_db_; }

  /// Shows all subapertures with this charge, and the aberration `modes`.
  void show(int charge, const std::vector<Mode>& modes);
  void set_gain(double gain_db);
  /// Takes images of what is shown, at the gain that was set. Errors: the gain was changed
  /// meanwhile.
  GrabbedImages grab(int frames);
  /// Where the daemon finds the spots of what is shown, one per subaperture: the mean of some
  /// frames; NaN: it is found in none.
  std::vector<Vec2> find_spots();
  /// The destructor restores, too.
  tl::expected<void, CallFailure> restore_after(tl::expected<void, CallFailure> done) {
    return before_->restore_after(std::move(done));
  }

 private:
  nlohmann::json call(const char* method,
                      const nlohmann::json& params = nlohmann::json::object()) const;

  Common common_;
  Config config_;
  Range<double> gains_db_{};
  std::optional<Borrow> before_;
  double gain_db_ = 0.0;
  int charge_shown_ = 0;
  bool shown_ = false;
  std::int64_t hologram_id_ = 0;
};

}  // namespace ovws::cli
