// The value of --fabric, a kind of cloth or a card, put into the text of a scene.
#ifndef CLOTHID_DATASETS_FABRIC_SCENE_WITH_FABRIC_H_
#define CLOTHID_DATASETS_FABRIC_SCENE_WITH_FABRIC_H_

#include <string>

#include "datasets/fabric/fabric_card.h"

namespace clothid {

// Whether `fabric` names a file, by its ending ".json" or because it is there, and no kind of cloth.
bool IsFabricCard(const std::string& fabric);

// `ReadFabricCard` of a card to be used. Throws `Error` (kBadData) also where none of its constants is told.
FabricCard ReadToldCard(const std::string& path);

// The text of a scene whose cloth is that of the card:
//   - what the card tells is the nominal value, and has a prior (`CardConstant::Prior`) unless the scene freezes it.
//     Bounds of the scene stay;
//   - with a constant of the membrane comes its law: constants of another law go, with what the scene says of them as
//     parameters. Likewise bending, which becomes that of patches;
//   - what the card only assumes is taken where the law needs it and the scene does not have it.
// Throws `Error`: kBadData for a text that is no JSON, kUsage where a constant that is told is a field of the scene;
// both name `source`.
std::string WithFabricCard(const std::string& scene_text, const FabricCard& card, const std::string& source);

// Either of them, `WithFabric` of sim/fabric/fabric.h or `WithFabricCard`, in one call.
std::string WithFabricOrCard(const std::string& scene_text, const std::string& fabric, const std::string& flag,
                             const std::string& source);

}  // namespace clothid

#endif  // CLOTHID_DATASETS_FABRIC_SCENE_WITH_FABRIC_H_
