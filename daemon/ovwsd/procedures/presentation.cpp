#include "daemon/ovwsd/procedures/presentation.hpp"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <new>
#include <optional>
#include <utility>

#include "core/port/clock.hpp"
#include "daemon/ovwsd/actor/mailbox.hpp"
#include "proto/methods.hpp"

namespace ovws {
namespace {

constexpr std::chrono::milliseconds kStopCheckInterval(
    20);                                      // interval of checks for a stop of the job
constexpr float kMaxPictureWaves = 16384.0F;  // beyond, the steps of float32 are 1/512 wave or more
constexpr float kGreyLevels = 256.0F;

std::size_t pixel_bytes(PictureType type) {
  return type == PictureType::phase ? sizeof(float) : sizeof(std::uint8_t);
}

Error over() {
  return {Errc::refused, "job",
          "this presentation does not run (any more): its lease has ended, or it was cancelled; "
          "leave out job to begin another"};
}

std::int64_t utc_of(std::int64_t mono_ns) {
  return utc_ns() + (mono_ns - monotonic_ns());
}

Picture picture_of(const SlmPresent& wish, const SlmGeometry& slm, const std::string& bytes) {
  Picture picture;
  picture.flatness = wish.flatness;
  picture.lut = wish.lut;
  picture.inside_pupil = wish.inside_pupil;
  picture.waves = Image<float>(slm.width_px, slm.height_px);
  std::vector<float>& waves = picture.waves.pixels;
  if (wish.type == PictureType::grey) {
    std::transform(bytes.begin(), bytes.end(), waves.begin(),
                   [](char level) { return float(std::uint8_t(level)) / kGreyLevels; });
    return picture;
  }
  std::memcpy(waves.data(), bytes.data(), bytes.size());
  return picture;
}

Result<void> check_phases(const std::string& bytes, int columns) {
  for (std::size_t at = 0; at < bytes.size(); at += sizeof(float)) {
    float waves = 0.0F;
    std::memcpy(&waves, &bytes[at], sizeof waves);
    if (std::abs(waves) <= kMaxPictureWaves) continue;  // false for NaN
    const int pixel = int(at / sizeof waves);
    return fail(
        Errc::invalid, "picture",
        fmt::format("the pixel in row {}, column {} is {}: give phases from -{} to {} "
                    "waves",
                    pixel / columns, pixel % columns, waves, kMaxPictureWaves, kMaxPictureWaves));
  }
  return {};
}

}  // namespace

/// One presentation. The procedure thread uses all but `orders` and `job`.
struct Presentations::Show {
  Mailbox orders;
  int job = 0;             ///< set before the first order is carried out
  Bench* bench = nullptr;  ///< null: it has ended, and orders are refused
  double lease_s = kLeaseS;
  std::int64_t ends_ns = 0;
  int pictures = 0;
  bool told = false;  ///< a client knows its number

  void renew() { ends_ns = monotonic_ns() + std::int64_t(1e9 * lease_s); }

  Result<PresentReport> present(const SlmPresent& wish, const SlmGeometry& slm,
                                const std::string& bytes);
  Result<PresentReport> carry_out(const SlmPresent& wish, const SlmGeometry& slm,
                                  const std::string& bytes);
};

Result<PresentReport> Presentations::Show::present(const SlmPresent& wish, const SlmGeometry& slm,
                                                   const std::string& bytes) {
  if (bench == nullptr) return fail(over());
  lease_s = wish.lease_s.value_or(lease_s);
  renew();
  std::optional<std::int64_t> t_settled_ns;
  if (!bytes.empty()) {
    Picture picture = picture_of(wish, slm, bytes);
    if (wish.correction) {
      picture.modes = shown_modes(HologramKind::grating, {}, bench->sensor()->correction);
    }
    const auto shared = std::make_shared<const Picture>(std::move(picture));
    const Painter paint = [shared](const HologramRenderer& renderer, Image<std::uint8_t>& grey) {
      renderer.render_picture(*shared, grey);
    };
    if (auto shown = bench->show(paint); !shown) return fail(shown.error());
    ++pictures;
    const auto settled_ns = bench->wait_settled();
    if (!settled_ns) return fail(settled_ns.error());
    t_settled_ns = utc_of(*settled_ns);
    renew();
  }
  PresentReport report{job, bench->sensor()->hologram_id, t_settled_ns, std::nullopt};
  if (lease_s > 0.0) report.t_lease_ns = utc_of(ends_ns);
  return report;
}

/// An order: `present`, whose failures do not keep the presentation from its next orders. It ends
/// at once if its first one failed, because no client knows its number then.
Result<PresentReport> Presentations::Show::carry_out(const SlmPresent& wish, const SlmGeometry& slm,
                                                     const std::string& bytes) {
  Result<PresentReport> report = fail(
      Errc::unavailable, "picture", "there is not enough memory for the picture: repeat it later");
  try {
    report = present(wish, slm, bytes);
  } catch (const std::bad_alloc&) {
  }
  told = told || report.has_value();
  if (!told) ends_ns = 0;
  return report;
}

std::size_t max_picture_bytes(const SlmGeometry& slm) {
  return sizeof(float) * std::size_t(slm.width_px) * std::size_t(slm.height_px);
}

Result<void> Presentations::check(const SlmPresent& wish, const std::string& bytes) const {
  if (bytes.empty() && wish.shape.empty() && wish.job) return {};
  if (wish.shape.empty()) {
    return fail(Errc::invalid, "shape",
                fmt::format("must be given with a picture: [{}, {}], rows and columns of the SLM",
                            slm_.height_px, slm_.width_px));
  }
  if (wish.shape != std::vector{slm_.height_px, slm_.width_px}) {
    return fail(Errc::invalid, "shape",
                fmt::format("is [{}, {}], but the SLM has {} rows and {} columns: give a picture "
                            "of the whole SLM",
                            wish.shape[0], wish.shape[1], slm_.height_px, slm_.width_px));
  }
  const std::size_t due =
      pixel_bytes(wish.type) * std::size_t(slm_.width_px) * std::size_t(slm_.height_px);
  if (bytes.size() == due) {
    return wish.type == PictureType::phase ? check_phases(bytes, slm_.width_px) : Result<void>{};
  }
  return fail(Errc::invalid, "picture",
              fmt::format("the binary frame after the JSON has {} bytes, but dtype and shape need "
                          "{}: send the picture's pixels as that frame",
                          bytes.size(), due));
}

void Presentations::present(const SlmPresent& wish, std::string bytes, Done done) {
  if (auto good = check(wish, bytes); !good) return done(fail(good.error()));
  auto shared = std::make_shared<std::string>(std::move(bytes));
  const auto order = [wish, slm = slm_, shared, done](const std::shared_ptr<Show>& show) {
    show->orders.post([wish, slm, shared, done, show = show.get()] {
      done(show->carry_out(wish, slm, *shared));
    });
  };
  if (!wish.job) return begin(order, done);
  const std::lock_guard lock(mutex_);
  if (!running_ || running_->job != *wish.job) return done(fail(over()));
  order(running_);
}

void Presentations::begin(std::function<void(const std::shared_ptr<Show>&)> order, Done done) {
  auto lease = leases_.take(Request::present);
  if (!lease) return done(fail(lease.error()));
  auto show = std::make_shared<Show>();
  procedures_.start(std::move(*lease),
                    {kSlmPresent.name, [this, show](Bench& bench) { return run(bench, show); }},
                    [this, show, order = std::move(order)](const Result<int>& job) {
                      show->job = *job;  // it has no condition that could refuse it
                      {
                        const std::lock_guard lock(mutex_);
                        running_ = show;
                      }
                      order(show);
                    });
}

/// Takes no more orders, and refuses those that wait. An order that throws does not keep the others
/// from their answers.
void Presentations::end(Show& show) {
  show.bench = nullptr;
  {
    const std::lock_guard lock(mutex_);
    running_.reset();
  }
  for (bool more = true; more;) {
    try {
      more = show.orders.run_one(std::chrono::milliseconds(0));
    } catch (...) {
      spdlog::error("slm.present: an order could not be answered, perhaps for lack of memory");
    }
  }
}

/// Carries out orders until the lease ends or the job is stopped.
Result<nlohmann::json> Presentations::run(Bench& bench, const std::shared_ptr<Show>& show) {
  show->bench = &bench;
  show->renew();
  try {
    while (!bench.stopped() && monotonic_ns() < show->ends_ns)
      (void)show->orders.run_one(kStopCheckInterval);
  } catch (...) {  // the job fails, and every order still gets its answer
    end(*show);
    throw;
  }
  end(*show);
  if (bench.stopped()) return fail(Errc::refused, "", "the job was stopped");
  return nlohmann::json{{"pictures", show->pictures}};
}

}  // namespace ovws
