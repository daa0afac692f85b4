#include "core/optics/noise.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/optics/noise_pixels.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#ifndef OVWS_NOISE_PIXELS_JOB  // once for all instruction sets
#define OVWS_NOISE_PIXELS_JOB

namespace ovws {

struct PixelNoiseJob {
  // Tables of Noise.
  const float* half_normals;
  const std::int32_t* poisson;
  unsigned count_bits;
  float per_electron, exact_poisson;
  std::uint32_t keys[4];
  PixelChain chain;
};

}  // namespace ovws

#endif

HWY_BEFORE_NAMESPACE();
namespace ovws::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr unsigned kQuantileBits = Noise::kQuantileBits;
constexpr float kMostElectrons = 1e9F;

/// Bit mixer of 32 bits, bijective (Wellons, "Prospecting for hash functions", 2018).
template <class U>
hn::Vec<U> Mixed(U u, hn::Vec<U> x) {
  x = hn::Xor(x, hn::ShiftRight<16>(x));
  x = hn::Mul(x, hn::Set(u, 0x7feb352dU));
  x = hn::Xor(x, hn::ShiftRight<15>(x));
  x = hn::Mul(x, hn::Set(u, 0x846ca68bU));
  return hn::Xor(x, hn::ShiftRight<16>(x));
}

/// Noise::normal of the upper 24 bits.
template <class F>
hn::Vec<F> Normal(F f, const PixelNoiseJob& job, hn::Vec<hn::RebindToUnsigned<F>> random) {
  const hn::RebindToUnsigned<F> u;
  const hn::RebindToSigned<F> i;
  const auto first = hn::BitCast(i, hn::ShiftRight<32 - kQuantileBits>(random));
  const auto second = hn::BitCast(i, hn::And(hn::ShiftRight<32 - 2 * kQuantileBits>(random),
                                             hn::Set(u, (1U << kQuantileBits) - 1)));
  return hn::Add(hn::GatherIndex(f, job.half_normals, first),
                 hn::GatherIndex(f, job.half_normals, second));
}

/// Poisson variate of a mean below 1/8, by its distribution function up to 4.
template <class F>
hn::Vec<F> PoissonBelowOne(F f, hn::Vec<F> mean, hn::Vec<F> random) {
  // exp(-mean) within 3e-7.
  auto power = hn::Set(f, 1.0F / 24.0F);
  for (const float coefficient : {-1.0F / 6.0F, 0.5F, -1.0F, 1.0F}) {
    power = hn::MulAdd(power, mean, hn::Set(f, coefficient));
  }
  auto probability = power, below = power, count = hn::Zero(f);
  for (const float next : {1.0F, 2.0F, 3.0F, 4.0F}) {
    count = hn::Add(count, hn::IfThenElseZero(hn::Ge(random, below), hn::Set(f, 1.0F)));
    probability = hn::Mul(probability, hn::Mul(mean, hn::Set(f, 1.0F / next)));
    below = hn::Add(below, probability);
  }
  return count;
}

template <class F>
hn::Vec<F> Poisson(F f, const PixelNoiseJob& job, hn::Vec<F> mean,
                   hn::Vec<hn::RebindToUnsigned<F>> random, hn::Vec<hn::RebindToUnsigned<F>> more) {
  const hn::RebindToUnsigned<F> u;
  const hn::RebindToSigned<F> i;
  const auto exact = hn::Lt(mean, hn::Set(f, job.exact_poisson));
  // Most vectors are all dark: skip what only bright pixels need.
  const auto many =
      hn::AllTrue(f, exact) ? mean : hn::MulAdd(hn::Sqrt(mean), Normal(f, job, more), mean);
  const auto small = hn::IfThenElseZero(exact, mean);
  const auto eighths = hn::ConvertTo(i, hn::Mul(small, hn::Set(f, job.per_electron)));
  const auto rest =
      hn::Sub(small, hn::Mul(hn::ConvertTo(f, eighths), hn::Set(f, 1.0F / job.per_electron)));
  const int share_bits = int(32 - job.count_bits);
  const auto count = hn::BitCast(i, hn::ShiftRightSame(random, share_bits));
  const auto share_mask = hn::Set(u, (1U << share_bits) - 1);
  const auto column = hn::BitCast(
      u, hn::GatherIndex(i, job.poisson,
                         hn::Add(hn::ShiftLeftSame(eighths, int(job.count_bits)), count)));
  // Both are below 2^25, so that signed numbers compare alike.
  const auto share = hn::BitCast(i, hn::And(column, share_mask));
  const auto drawn = hn::BitCast(i, hn::And(random, share_mask));
  const auto alias = hn::BitCast(i, hn::ShiftRightSame(column, share_bits));
  const auto most = hn::ConvertTo(f, hn::IfThenElse(hn::Lt(drawn, share), count, alias));
  const auto uniform =
      hn::Mul(hn::ConvertTo(f, hn::BitCast(i, hn::ShiftRight<8>(more))), hn::Set(f, 0x1p-24F));
  return hn::IfThenElse(exact, hn::Add(most, PoissonBelowOne(f, rest, uniform)), many);
}

template <class F>
void ExposeLanes(F f, const PixelNoiseJob& job, std::uint32_t first, const float* mean_e,
                 std::uint16_t* dn) {
  const hn::RebindToUnsigned<F> u;
  const hn::RebindToSigned<F> i;
  const hn::Rebind<std::uint16_t, F> narrow;
  const PixelChain& chain = job.chain;
  const auto number = hn::Xor(hn::Iota(u, first), hn::Set(u, job.keys[0]));
  const auto mixed = Mixed(u, number);
  const auto random = [&](int key) { return Mixed(u, hn::Add(mixed, hn::Set(u, job.keys[key]))); };
  auto electrons = hn::LoadU(f, mean_e);
  electrons = hn::IfThenElseZero(hn::Eq(electrons, electrons), electrons);
  if (chain.shot_noise) {
    const auto mean = hn::Min(hn::Max(electrons, hn::Zero(f)), hn::Set(f, kMostElectrons));
    electrons = Poisson(f, job, mean, random(1), random(2));
  }
  const auto read_e = hn::MulAdd(hn::Set(f, chain.read_noise_e), Normal(f, job, random(3)),
                                 hn::Min(electrons, hn::Set(f, chain.full_well_e)));
  const auto level = hn::MulAdd(read_e, hn::Set(f, chain.dn_per_e), hn::Set(f, chain.black_dn));
  const auto clipped = hn::Min(hn::Max(level, hn::Zero(f)), hn::Set(f, chain.top_dn));
  const auto rounded = hn::ConvertTo(i, hn::Add(clipped, hn::Set(f, 0.5F)));
  hn::StoreU(hn::DemoteTo(narrow, rounded), narrow, dn);
}

void Expose(const PixelNoiseJob& job, const float* mean_e, std::size_t count, std::uint16_t* dn) {
  const hn::ScalableTag<float> f;
  const hn::CappedTag<float, 1> one;
  std::size_t k = 0;
  for (; k + hn::Lanes(f) <= count; k += hn::Lanes(f)) {
    ExposeLanes(f, job, std::uint32_t(k), mean_e + k, dn + k);
  }
  for (; k < count; ++k) ExposeLanes(one, job, std::uint32_t(k), mean_e + k, dn + k);
}

}  // namespace
}  // namespace ovws::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace ovws {

HWY_EXPORT(Expose);

namespace {

constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15U;

}  // namespace

void Noise::expose(std::uint64_t seed, std::uint64_t stream, const PixelChain& chain,
                   std::span<const float> mean_e, std::uint16_t* dn) {
  const Tables& known = tables();
  PixelNoiseJob job{known.half_normals.data(),
                    known.poisson.data(),
                    Column::kCountBits,
                    float(Tables::kPerElectron),
                    kExactPoisson,
                    {},
                    chain};
  std::uint64_t state = split_mix(split_mix(seed) + stream);
  for (std::uint32_t& key : job.keys) key = std::uint32_t(split_mix(state += kGolden) >> 32);
  HWY_DYNAMIC_DISPATCH(Expose)(job, mean_e.data(), mean_e.size(), dn);
}

}  // namespace ovws

#endif  // HWY_ONCE
