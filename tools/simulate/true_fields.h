// Fields that a simulated recording is to have for its truth.
#ifndef CLOTHID_TOOLS_SIMULATE_TRUE_FIELDS_H_
#define CLOTHID_TOOLS_SIMULATE_TRUE_FIELDS_H_

#include <string>

#include "sim/scene/scene.h"

namespace clothid {

// "k_stretch=FILE.npy,density=OTHER.npy" of --set_field: puts the fields into `scene` in place of those that it has of
// these constants, and their levels into its material and nominal values. Throws `Error`: kUsage for items of another
// form, constants that can be no field or are given twice; as `ReadFieldValues` does for files.
void SetTrueFields(const std::string& text, Scene* scene);

}  // namespace clothid

#endif  // CLOTHID_TOOLS_SIMULATE_TRUE_FIELDS_H_
