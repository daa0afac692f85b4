/// Ranges of all numbers that a user can set, shared by the wire, the configuration and the JSON
/// Schemas. A device may have a smaller range.
#pragma once

#include <cstddef>

namespace ovws::limits {

struct Numbers {
  double min, max;
};
struct Integers {
  int min, max;
};

constexpr Numbers kGainDb{-100.0, 100.0};
constexpr Numbers kGainRaw{-1e9, 1e9};
constexpr Numbers kExposureUs{0.1, 60e6};
constexpr Numbers kExposureTarget{0.05, 0.95};  ///< of most spots, fraction of full scale
constexpr Numbers kFrameRateHz{0.001, 100e3};
constexpr Integers kRoiOffset{0, 65535};
constexpr Integers kRoiSize{1, 65535};
constexpr Integers kPacketSizeBytes{576, 65000};
constexpr Numbers kTransferMs{0.0, 10e3};

constexpr Integers kSlmSizePx{16, 16384};
constexpr Numbers kSlmPitchUm{0.1, 1000.0};
constexpr Numbers kSettleMs{0.0, 10e3};

constexpr Numbers kWavelengthNm{100.0, 20e3};
constexpr Numbers kFocalLengthMm{1.0, 100e3};
constexpr Numbers kMagnification{0.001, 1000.0};
constexpr Numbers kCameraPitchUm{0.1, 100.0};
constexpr Numbers kCentrePx{-65535.0, 65535.0};
constexpr Numbers kPxPerCycle{-1e7, 1e7};
constexpr double kMinPxPerCycle = 1.0;

constexpr Integers kCharge{-8, 8};
constexpr Numbers kMaskWaves{-10.0, 10.0};
constexpr Integers kSubaperturesAcross{1, 64};
constexpr Numbers kLensletPitchUm{10.0, 10e3};
constexpr Numbers kPupilMm{0.05, 1000.0};
constexpr Numbers kLensletWidthPx{1.0, 16384.0}, kLensletPlacePx{-65535.0, 65535.0};
constexpr Numbers kLensletPxPerCycle{1.0, 1e7};
constexpr Integers kPatternSlots{0, 24};  ///< bits of a pixel that a DMD plays; not 1
constexpr Integers kPlateLevels{0, 256};  ///< steps of a spiral phase plate; 0: smooth
constexpr Numbers kPlateDepth{0.5, 1.5};  ///< relative to the design
constexpr Numbers kPlateShiftUm{-1e3, 1e3}, kPlateShiftPx{-1e4, 1e4};
constexpr Numbers kPupilDiameterPx{8.0, 16384.0};
constexpr Numbers kGrooves{-8192.0, 8192.0};
constexpr Numbers kSpacing{0.001, 16.0};
constexpr Numbers kKernelRadius{0.1, 2.0};
constexpr Integers kEstimates{2, 8};  ///< numbers estimated per spot

constexpr Numbers kModeWaves{-1000.0, 1000.0};
constexpr Integers kReferenceFrames{1, 100000};
constexpr Numbers kLoopGain{0.001, 1.0};
constexpr Numbers kLoopLeak{0.0, 0.99};
constexpr Numbers kLoopLimitWaves{0.001, 100.0};
constexpr Numbers kLoopPatienceS{0.1, 3600.0};
constexpr Numbers kIdentifyS{1.0, 600.0};
constexpr Integers kImageFrames{1, 100};
constexpr Integers kMapPatterns{4, 10};
constexpr Integers kMapCells{32, 256};
constexpr Integers kGreyLevels{9, 256};  ///< grey levels that lut.run measures
constexpr Integers kSettleRepetitions{3, 200};
constexpr Numbers kLeaseS{0.0, 3600.0};  ///< of a presentation, slm.present
constexpr Integers kGrabFrames{1, 1000};
constexpr Numbers kGrabTimeoutS{0.1, 600.0};
constexpr std::size_t kGrabBytes = 64 << 20;      ///< of the frames of one camera.grab
constexpr Numbers kWatchMs{20.0, 10'000.0};       ///< time that slm.settle watches each change
constexpr Numbers kPokeWaves{0.005, 0.2};         ///< poke amplitude of a calibration
constexpr Integers kPokeFrames{2, 10000};         ///< frames averaged for each poke
constexpr Numbers kGivenPokeWaves{0.001, 100.0};  ///< poke amplitude by a client's own mirror
constexpr Integers kActuators{1, 4096};           ///< of an external corrector
constexpr Integers kMatrixRows{1, 4096};          ///< x and y of each spot
constexpr Integers kJob{1, 2147483647};
constexpr Integers kSweepFrames{2, 1000};  ///< frames of a sweep's cell, or of its reference
constexpr std::size_t kSweepGains = 64, kSweepAberrations = 16, kSweepArms = 16;  ///< at most
constexpr std::size_t kSweepImages = 8;  ///< gains with an image of each charge

constexpr Numbers kRefineRateHz{0.001, 100.0};
constexpr Numbers kElectronsPerDn{1e-6, 1e6};
constexpr Numbers kReadNoiseE{0.0, 1e6};
constexpr Numbers kFullWellE{100.0, 1e6};
constexpr Numbers kPhotoElectronsPerS{1.0, 1e15};
constexpr Integers kAdvisedModes{3, 200};  ///< wanted of a sensor
constexpr Numbers kBlackLevelDn{0.0, 65535.0};
constexpr Numbers kSaturationDn{1.0, 65535.0};

constexpr Integers kImagesEvery{0, 1'000'000};  ///< a recording has every n-th image; 0: none
constexpr Numbers kRecordS{0.1, 1e7};
constexpr Numbers kRecordMib{1.0, 1e9};
constexpr std::size_t kRecordName = 100;  ///< maximum length, characters
constexpr Integers kRecordBufferMib{8, 4096};

constexpr Numbers kImageRateHz{0.0, 1000.0};
constexpr Integers kWorkers{0, 16};
constexpr Integers kRecords{8, 4096};  ///< must be a power of two
constexpr Integers kCpu{0, 1023};
constexpr std::size_t kMaxCpus = 64;

/// Images whose 16 brightest pixels reach less than this fraction of full scale are called dark.
constexpr double kDarkFraction = 0.05;
/// With a larger fraction of its spots saturated an image is called too bright, and no reference is
/// taken.
constexpr double kMaxSaturatedSpots = 0.1;
/// Up to this fraction of the SLM's pixels may differ from the hologram: a pointer or a message of
/// another program covers fewer.
constexpr double kMaxDifferingPixels = 0.01;

}  // namespace ovws::limits
