#include "core/optics/hologram_row.hpp"

#include <algorithm>
#include <array>

#include "core/optics/phasors.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/optics/hologram_row.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ovws::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR

/// Scalar version of mirrored_phases for CPUs without SIMD vectors.
void Mirrored(const double* even, const double* odd, int pairs, const double* x, int count,
              std::uint16_t* right, std::uint16_t* left) {
  for (int at = 0; at < count; ++at) {
    const double square = x[at] * x[at];
    double even_sum = even[0], odd_sum = odd[0];
    for (int k = 1; k < pairs; ++k) {
      even_sum = even_sum * square + even[k];
      odd_sum = odd_sum * square + odd[k];
    }
    right[at] = phase16((even_sum + odd_sum * x[at]) / kPhasesPerWave);
    left[-at] = phase16((even_sum - odd_sum * x[at]) / kPhasesPerWave);
  }
}

#else

using Doubles = hn::ScalableTag<double>;
using Phases = hn::Repartition<std::uint16_t, Doubles>;
constexpr int kVectors = 4;  // vectors of doubles that give one vector of 16-bit phases
using Numbers = std::array<hn::Vec<Doubles>, kVectors>;

/// sum * x + term, rounded twice. A fused multiply-add would make the result depend on the CPU.
hn::Vec<Doubles> multiply_add(hn::Vec<Doubles> sum, hn::Vec<Doubles> x, double term) {
  return hn::Add(hn::Mul(sum, x), hn::Set(Doubles(), term));
}

/// Rounds each number (in 1/65536 wave) to a 16-bit phase, as phase16 does.
hn::Vec<Phases> rounded(const Numbers& steps) {
  using Halves = hn::Repartition<std::uint32_t, Doubles>;
  const auto bits = [&](int v) {
    return hn::BitCast(Halves(), hn::Add(steps[v], hn::Set(Doubles(), kRounder)));
  };
  const auto first = hn::ConcatEven(Halves(), bits(1), bits(0));
  const auto second = hn::ConcatEven(Halves(), bits(3), bits(2));
  return hn::ConcatEven(Phases(), hn::BitCast(Phases(), second), hn::BitCast(Phases(), first));
}

void Mirrored(const double* even, const double* odd, int pairs, const double* x, int count,
              std::uint16_t* right, std::uint16_t* left) {
  const int lanes = int(hn::Lanes(Doubles())), pixels = kVectors * lanes;
  for (int at = 0; at < count; at += pixels) {
    Numbers square, even_sum, odd_sum;
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) {
      const auto position = hn::LoadU(Doubles(), x + at + v * lanes);
      square[v] = hn::Mul(position, position);
      even_sum[v] = hn::Set(Doubles(), even[0]);
      odd_sum[v] = hn::Set(Doubles(), odd[0]);
    }
    for (int k = 1; k < pairs; ++k) {
#pragma GCC unroll 4
      for (int v = 0; v < kVectors; ++v) {
        even_sum[v] = multiply_add(even_sum[v], square[v], even[k]);
        odd_sum[v] = multiply_add(odd_sum[v], square[v], odd[k]);
      }
    }
    Numbers sum, difference;
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) {
      odd_sum[v] = hn::Mul(odd_sum[v], hn::LoadU(Doubles(), x + at + v * lanes));
      sum[v] = hn::Add(even_sum[v], odd_sum[v]);
      difference[v] = hn::Sub(even_sum[v], odd_sum[v]);
    }
    hn::StoreU(rounded(sum), Phases(), right + at);
    hn::StoreU(hn::Reverse(Phases(), rounded(difference)), Phases(), left - at - pixels + 1);
  }
}

#endif

#if HWY_TARGET <= HWY_AVX2

using Levels = hn::ScalableTag<std::uint8_t>;
using Words = hn::Repartition<std::uint16_t, Levels>;

/// LUT indices for as many pixels as a vector has bytes: the high bytes of base + added.
hn::Vec<Levels> indices(const std::uint16_t* base, const std::uint16_t* added) {
  const auto sum = [=](std::size_t at) {
    const auto phase = hn::Add(hn::LoadU(Words(), base + at), hn::LoadU(Words(), added + at));
    return hn::BitCast(Levels(), phase);
  };
  return hn::ConcatOdd(Levels(), sum(hn::Lanes(Words())), sum(0));
}

hn::Mask<Levels> in_upper_half(hn::Vec<Levels> index) {
  return hn::Gt(index, hn::Set(Levels(), 0x7F));
}

#if HWY_TARGET <= HWY_AVX3_DL

/// LUT in four AVX-512 registers, looked up by byte permutations (VBMI) over two registers each.
class Lut {
 public:
  explicit Lut(const std::uint8_t* lut) {
    for (int k = 0; k < 4; ++k) quarters_[k] = hn::LoadU(Levels(), lut + 64 * k);
  }
  hn::Vec<Levels> at(hn::Vec<Levels> index) const {
    return hn::IfThenElse(in_upper_half(index), half(2, index), half(0, index));
  }

 private:
  hn::Vec<Levels> half(int first, hn::Vec<Levels> index) const {
    return {_mm512_permutex2var_epi8(quarters_[first].raw, index.raw, quarters_[first + 1].raw)};
  }
  std::array<hn::Vec<Levels>, 4> quarters_;
};

#else

/// LUT looked up by byte shuffles. Each half of the LUT has 8 rows of 16 levels; a row is repeated
/// in all 128-bit blocks of a vector. XOR delta coding: rows after the first of a half are stored
/// XORed with the previous row.
class Lut {
 public:
  explicit Lut(const std::uint8_t* lut) {
    for (int k = 0; k < 16; ++k) {
      rows_[k] = hn::LoadDup128(Levels(), lut + 16 * k);
      if (k % 8 != 0) rows_[k] = hn::Xor(rows_[k], hn::LoadDup128(Levels(), lut + 16 * (k - 1)));
    }
  }
  hn::Vec<Levels> at(hn::Vec<Levels> index) const {
    // In step k, indices below 16 k have wrapped to 128 or more; the shuffle returns 0 for them.
    auto in_half = hn::And(index, hn::Set(Levels(), 0x7F));
    auto low = hn::TableLookupBytes(rows_[0], in_half);
    auto high = hn::TableLookupBytes(rows_[8], in_half);
#pragma GCC unroll 8
    for (int k = 1; k < 8; ++k) {
      in_half = hn::Sub(in_half, hn::Set(Levels(), 16));
      low = hn::Xor(low, hn::TableLookupBytesOr0(rows_[k], in_half));
      high = hn::Xor(high, hn::TableLookupBytesOr0(rows_[8 + k], in_half));
      // Compiler barrier: keeps the order of steps, because combining them last spills registers.
      __asm__("" : "+x"(in_half.raw), "+x"(low.raw), "+x"(high.raw));
    }
    return hn::IfThenElse(in_upper_half(index), high, low);
  }

 private:
  std::array<hn::Vec<Levels>, 16> rows_;
};

#endif

void Greys(const std::uint16_t* base, const std::uint16_t* added, const std::uint8_t* lut,
           int count, std::uint8_t* grey) {
  const int lanes = int(hn::Lanes(Levels()));
  if (count < lanes) {
    for (int x = 0; x < count; ++x) grey[x] = lut[std::uint16_t(base[x] + added[x]) >> 8];
    return;
  }
  const Lut levels(lut);
  for (int x = 0; x < count; x += lanes) {
    x = std::min(x, count - lanes);  // the last block overlaps the previous one
    hn::StoreU(levels.at(indices(base + x, added + x)), Levels(), grey + x);
  }
}

#else

void Greys(const std::uint16_t* base, const std::uint16_t* added, const std::uint8_t* lut,
           int count, std::uint8_t* grey) {
  for (int x = 0; x < count; ++x) grey[x] = lut[std::uint16_t(base[x] + added[x]) >> 8];
}

#endif

}  // namespace
}  // namespace ovws::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ovws {
HWY_EXPORT(Mirrored);
HWY_EXPORT(Greys);

void mirrored_phases(std::span<const double> waves, const double* x, int count,
                     std::uint16_t* right, std::uint16_t* left) {
  std::array<double, kMaxPhasePowers / 2 + 1> even{}, odd{};  // from the highest power down
  const std::size_t pairs = (waves.size() + 1) / 2;
  for (std::size_t k = 0; k < waves.size(); ++k) {
    (k % 2 == 0 ? even : odd)[pairs - 1 - k / 2] = kPhasesPerWave * waves[k];
  }
  HWY_DYNAMIC_DISPATCH(Mirrored)(even.data(), odd.data(), int(pairs), x, count, right, left);
}

void look_up_greys(const std::uint16_t* base, const std::uint16_t* added, const std::uint8_t* lut,
                   int count, std::uint8_t* grey) {
  HWY_DYNAMIC_DISPATCH(Greys)(base, added, lut, count, grey);
}

void switch_mirrors(const std::uint16_t* base, const std::uint16_t* added,
                    const std::uint16_t* limits, int count, std::uint8_t* grey) {
  for (int x = 0; x < count; ++x) {
    const auto phase = std::uint16_t(base[x] + added[x]);
    const auto distance = std::min(phase, std::uint16_t(-phase));
    grey[x] = distance < limits[x] ? 255 : 0;
  }
}

}  // namespace ovws
#endif  // HWY_ONCE
