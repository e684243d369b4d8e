// bands.npz, the bands of a prediction for NumPy.
//
//   times [T] s; quantiles [5]; positions [5, T, N, 3] m, of every node and time; spread [T] and moved [T] m, see
//   `Prediction`; share_parameters, share_finer, share_start, share_handles, share_rest [T], and share_NAME [T] of
//   every parameter that was drawn, see `SpreadShares`; of what was asked for (identify/prediction/derived.h) point_N
//   [5, T, 3] m, area [5, T] m^2, strain [5, T], force [5, T, G, 3] N of the grippers, slip [5] s; where the draws are
//   kept, draws [D, T, N, 3] m.
#ifndef CLOTHID_IDENTIFY_PREDICTION_BANDS_FILE_H_
#define CLOTHID_IDENTIFY_PREDICTION_BANDS_FILE_H_

#include <string>
#include <utility>
#include <vector>

#include "identify/prediction/prediction.h"

namespace clothid {

// The bytes of an uncompressed ZIP archive of files of these names and contents, in which nothing depends on the clock.
// Throws `Error` (kUsage) for more than the 4 GB that such an archive holds.
std::string ArchiveBytes(const std::vector<std::pair<std::string, std::string>>& files);

// `with_draws`: with all of `Prediction::cloths`.
std::string BandsNpz(const Prediction& prediction, const FitPosterior& posterior, bool with_draws);

}  // namespace clothid

#endif  // CLOTHID_IDENTIFY_PREDICTION_BANDS_FILE_H_
