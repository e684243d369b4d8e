// Variants of a scene: numbers of its JSON text changed.
#ifndef CLOTHID_TOOLS_LANDSCAPE_SCENE_VARIANT_H_
#define CLOTHID_TOOLS_LANDSCAPE_SCENE_VARIANT_H_

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "datasets/motion/motion_file.h"
#include "datasets/motion/recorded_motion.h"

namespace clothid {

// The most of a sweep: combinations, keys, and the parts of a key.
inline constexpr std::size_t kMaxVariants = 10000;
inline constexpr std::size_t kMaxSweepKeys = 16;
inline constexpr std::size_t kMaxKeyParts = 16;

// One number of a scene. The key is a path into its text: NAME.key for an obstacle of that name (an obstacle without
// one is called by its type, see datasets/scene.md), else from the top, as in "touch" or "wind.mean.x"; x, y, z or an
// index pick a number of an array.
struct SceneChange {
  std::string key;
  double value = 0.0;
};

// Changes to be made one after the other. Empty: the scene as it is.
using SceneVariant = std::vector<SceneChange>;

// "ball.center.x=-0.05,0.05;touch=1e-5,1e-3": every combination of the values of the keys, the last key fastest. Empty:
// one variant, that changes nothing. Throws `Error` (kUsage), naming --sweep, for items that are no KEY=NUMBER[,...],
// and for a key, or a value of a key, that is there twice; also beyond kMaxVariants or kMaxSweepKeys.
std::vector<SceneVariant> ParseSweep(const std::string& text);

// "ball.center.x=-0.05;touch=1e-05", of which `ParseSweep` makes exactly this variant again.
std::string VariantName(const SceneVariant& variant);

// The changed text. `obstacle_names` are those of the scene that `scene_text` describes. A key that the text does not
// have is added: whoever reads the text knows whether there is such a key. Throws `Error` (kUsage), naming --sweep,
// where a key leads to something that is not a number, or off an array, or has more than kMaxKeyParts.
std::string ChangeScene(const std::string& scene_text, const std::vector<std::string>& obstacle_names,
                        const SceneVariant& variant);

// A recording as such options make it: `ReadMotion` of a file, or `InterpretMotion` of what is in memory.
using MotionReader = std::function<RecordedMotion(const ReadMotionOptions&)>;

// What `read` gives with these options, and with these changes of the scene. Throws `Error`: what `read` does for the
// scene as it is, else kUsage, naming --sweep and the variant; also for changes without any effect: `duration`, which a
// recording has of its own, and `parameters`, which are for fits.
RecordedMotion ReadMotionVariant(const MotionReader& read, ReadMotionOptions options, const SceneVariant& variant);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_LANDSCAPE_SCENE_VARIANT_H_
