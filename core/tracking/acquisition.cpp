#include "core/tracking/acquisition.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ovws {
namespace {

constexpr double kSameSpot = 0.5;     // lambda/d: two fixes closer than this are one spot
constexpr double kNearPitches = 1.5;  // a spot is near the expected ones up to this distance

/// Near the expected spots: two for each place of a lattice that goes on for kNearPitches. Light
/// fills these places behind a wide array; noise and the rims of spots may look brighter than a
/// spot. Elsewhere: the whole lattice may have moved, and other diffraction orders and stray light
/// may be brighter than its spots.
CandidateFinder::Most most_candidates(std::size_t subapertures) {
  const double row = std::sqrt(double(subapertures)) + 2.0 * kNearPitches;
  return {int(2.0 * row * row), int(2 * subapertures) + 12};
}

int total(CandidateFinder::Most most) {
  return most.near + most.elsewhere;
}

Vec2 position(const SpotFix& fix) {
  return {double(fix.x), double(fix.y)};
}

/// Whether norm(a - b) < distance, in most cases computed without a square root.
bool closer(Vec2 a, Vec2 b, double distance) {
  const Vec2 d = a - b;
  return std::abs(d.x) < distance && std::abs(d.y) < distance && norm(d) < distance;
}

}  // namespace

Acquisition::Acquisition(SpotModel spots, const std::vector<Vec2>& predicted_px, int image_width,
                         int image_height, const Acquisition* before, std::optional<Disc> within,
                         std::shared_ptr<const SpotKinds> kinds)
    : spots_(spots),
      image_width_(image_width),
      image_height_(image_height),
      within_(within),
      kinds_(std::move(kinds)),
      assignment_(predicted_px,
                  total(most_candidates(predicted_px.size())) * (kinds_ ? kinds_->count() : 1),
                  kinds_ ? kinds_->of_spots() : std::vector<int>{}) {
  const bool same = before != nullptr && before->spots_ == spots &&
                    before->image_width_ == image_width && before->image_height_ == image_height &&
                    before->assignment_.size() == assignment_.size() && before->kinds_ == kinds_;
  const CandidateFinder::Most most = most_candidates(predicted_px.size());
  if (same) candidates_ = before->candidates_;
  for (int kind = int(candidates_.size()); kind < (kinds_ ? kinds_->count() : 1); ++kind) {
    candidates_.push_back(std::make_shared<CandidateFinder>(kinds_ ? kinds_->model(kind) : spots,
                                                            image_width, image_height, most));
  }
  verified_.reserve(candidates_.size() * std::size_t(total(most)));
  positions_.reserve(verified_.capacity());
  verified_kinds_.reserve(verified_.capacity());
}

int Acquisition::acquire(const ImageView& image, const SpotTracker& tracker, TrackScratch& scratch,
                         std::span<SpotFix> out) {
  std::fill(out.begin(), out.end(), SpotFix{});
  positions_.clear();
  if (image.width != image_width_ || image.height != image_height_) return 0;
  verify(image, tracker, scratch);
  const std::span<const int> matched =
      assignment_.match(positions_, SpotAssignment::Rules{}, verified_kinds_);
  bool any = false;
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (matched[i] == SpotAssignment::kNone) continue;
    out[i] = verified_[std::size_t(matched[i])];
    any = true;
  }
  if (!any) return 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (out[i].found()) continue;
    const SpotFix fix = search_where_expected(
        int(i), image, kinds_ ? kinds_->tracker_of(int(i)) : tracker, scratch);
    if (fix.found() && !taken(position(fix), out)) out[i] = fix;
  }
  const int found =
      drop_faint(out, int(out.size()), kinds_ ? kinds_->levels() : std::span<const float>{});
  if (found >= assignment_.least_found(SpotAssignment::Rules{})) return found;
  std::fill(out.begin(), out.end(), SpotFix{});
  return 0;
}

void Acquisition::verify(const ImageView& image, const SpotTracker& tracker,
                         TrackScratch& scratch) {
  verified_.clear();
  verified_kinds_.clear();
  if (!kinds_) verify_kind(0, image, tracker, scratch);
  for (int kind = 0; kinds_ && kind < kinds_->count(); ++kind) {
    verify_kind(kind, image, kinds_->tracker(kind), scratch);
  }
  for (const SpotFix& fix : verified_) positions_.push_back(position(fix));
}

void Acquisition::verify_kind(int kind, const ImageView& image, const SpotTracker& tracker,
                              TrackScratch& scratch) {
  const std::size_t first = verified_.size();
  const auto of_kind = [&] { return std::span(verified_).subspan(first); };
  const CandidateFinder::Parts parts{assignment_.part_around(kNearPitches), within_};
  for (const Vec2 start : candidates_[std::size_t(kind)]->find(image, parts)) {
    const SpotFix fix = tracker.track(image, start, scratch);
    if (fix.found() && !taken(position(fix), of_kind())) verified_.push_back(fix);
  }
  drop_faint(of_kind(), kinds_ ? kinds_->spots_of(kind) : assignment_.size());
  verified_.erase(std::remove_if(verified_.begin() + std::ptrdiff_t(first), verified_.end(),
                                 [](const SpotFix& fix) { return !fix.found(); }),
                  verified_.end());
  verified_kinds_.resize(verified_.size(), kind);
}

SpotFix Acquisition::search_where_expected(int i, const ImageView& image,
                                           const SpotTracker& tracker,
                                           TrackScratch& scratch) const {
  const Vec2 expected = assignment_.expected(i);
  const SpotFix fix = tracker.track(image, expected, scratch);
  if (!fix.found() || norm(position(fix) - expected) > assignment_.tolerance_px()) return {};
  return fix;
}

bool Acquisition::taken(Vec2 at, std::span<const SpotFix> fixes) const {
  return std::any_of(fixes.begin(), fixes.end(), [&](const SpotFix& fix) {
    return fix.found() && closer(position(fix), at, kSameSpot * spots_.lambda_d_px);
  });
}

}  // namespace ovws
