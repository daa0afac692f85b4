// Unpacking of every layout with every instruction set, from every position in a row, without
// reading a byte beyond it.
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstring>
#include <string>
#include <vector>

#include "core/base/unpack.hpp"
#include "tests/support/every_target.hpp"
#include "tests/unit/base/packed_image.hpp"

namespace ovws {
namespace {

/// Bytes that end at an inaccessible memory page: reading one more crashes.
class AtTheEdge {
 public:
  explicit AtTheEdge(const std::vector<std::byte>& bytes) {
    const auto page = std::size_t(sysconf(_SC_PAGESIZE));
    const std::size_t pages = bytes.size() / page + 1;
    size_ = (pages + 1) * page;
    memory_ = static_cast<std::byte*>(
        mmap(nullptr, size_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
    std::byte* const edge = memory_ + pages * page;
    mprotect(edge, page, PROT_NONE);
    first_ = edge - bytes.size();
    std::memcpy(first_, bytes.data(), bytes.size());
  }
  ~AtTheEdge() { munmap(memory_, size_); }
  AtTheEdge(const AtTheEdge&) = delete;
  AtTheEdge& operator=(const AtTheEdge&) = delete;

  const std::byte* first() const { return first_; }

 private:
  std::byte* memory_ = nullptr;
  std::byte* first_ = nullptr;
  std::size_t size_ = 0;
};

class Unpack : public testing::TestWithParam<PixelFormat> {
 protected:
  static constexpr int kWidth = 76;

  /// Unpacks every run of pixels of a row, every `step`-th, with each target of this CPU.
  void expect_all(int step, int shift) {
    test::with_every_target([&] { expect_runs(step, shift); });
  }

 private:
  void expect_runs(int step, int shift) {
    const PixelFormat format = GetParam();
    const Image<std::uint16_t> picture = test::random_image(kWidth, 1, format, 7);
    const std::vector<std::byte> bytes = test::pack(picture, format, 0, shift);
    const AtTheEdge memory(bytes);
    const PackedRow row{memory.first(), std::ptrdiff_t(bytes.size()), shift};
    const UnpackRow unpack = unpack_row(traits_of(format).layout, step);
    for (int from = 0; from < kWidth; ++from) {
      for (int count = 0; from + (count - 1) * step < kWidth; ++count) {
        std::vector<std::uint16_t> out(std::size_t(count) + 1, 0xABCD);
        unpack(row, from, count, out.data());
        for (int i = 0; i < count; ++i) {
          ASSERT_EQ(out[std::size_t(i)], picture.at(from + i * step, 0))
              << "step " << step << " pixel " << i << " of " << count << " from " << from;
        }
        ASSERT_EQ(out.back(), 0xABCD) << "wrote beyond what was asked for";
      }
    }
  }
};

TEST_P(Unpack, GivesTheNumbersThatWerePacked) {
  expect_all(1, 0);
  expect_all(2, 0);
}

class UnpackWords : public Unpack {};
TEST_P(UnpackWords, MovesLeftJustifiedWordsDown) {
  const PixelFormatTraits& traits = traits_of(GetParam());
  expect_all(1, 16 - traits.bits);
  expect_all(2, 16 - traits.bits);
}

// Bayer formats have the same memory layout as monochrome ones.
constexpr PixelFormat kWords[] = {PixelFormat::mono10, PixelFormat::mono12, PixelFormat::mono14,
                                  PixelFormat::mono16};
constexpr PixelFormat kOthers[] = {PixelFormat::mono8, PixelFormat::mono10p, PixelFormat::mono12p,
                                   PixelFormat::mono10_packed, PixelFormat::mono12_packed};

INSTANTIATE_TEST_SUITE_P(Words, Unpack, testing::ValuesIn(kWords), test::format_name);
INSTANTIATE_TEST_SUITE_P(Words, UnpackWords, testing::ValuesIn(kWords), test::format_name);
INSTANTIATE_TEST_SUITE_P(Others, Unpack, testing::ValuesIn(kOthers), test::format_name);

}  // namespace
}  // namespace ovws
