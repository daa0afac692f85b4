#include "core/optics/identify_picture.hpp"

#include <array>
#include <string_view>

namespace ovws {
namespace {

constexpr int kCols = 30;
constexpr std::array<std::string_view, 18> kPicture{"##############################",  //
                                                    "#                            #",  //
                                                    "#  ###  #   # #   #  ####    #",  //
                                                    "# #   # #   # #   # #        #",  //
                                                    "# #   # #   # #   # #        #",  //
                                                    "# #   # #   # # # #  ###     #",  //
                                                    "# #   #  # #  # # #     #    #",  //
                                                    "# #   #  # #  ## ##     #    #",  //
                                                    "#  ###    #   #   # ####     #",  //
                                                    "#                            #",  //
                                                    "#   #              #         #",  //
                                                    "#   #   # #         #  #   # #",  //
                                                    "# # # # # #  #########  # #  #",  //
                                                    "#  ###   #          #    #   #",  //
                                                    "#   #    #         #    # #  #",  //
                                                    "#       #              #   # #",  //
                                                    "#                            #",  //
                                                    "##############################"};

}  // namespace

void draw_identify_picture(Image<std::uint8_t>& grey) {
  const int rows = static_cast<int>(kPicture.size());
  for (int y = 0; y < grey.height; ++y) {
    const std::string_view line = kPicture[std::int64_t{y} * rows / grey.height];
    for (int x = 0; x < grey.width; ++x) {
      grey.at(x, y) = line[std::int64_t{x} * kCols / grey.width] == '#' ? 255 : 0;
    }
  }
}

}  // namespace ovws
