# clothid_import_library(<name> <header> [<folder of the header>]): the target clothid::<name> for a library that brings
# no CMake package of its own. No target where the library is not found.
function(clothid_import_library name header)
  find_library(CLOTHID_${name}_LIBRARY ${name})
  find_path(CLOTHID_${name}_INCLUDE_DIR ${header} PATH_SUFFIXES ${ARGN})
  mark_as_advanced(CLOTHID_${name}_LIBRARY CLOTHID_${name}_INCLUDE_DIR)
  if(CLOTHID_${name}_LIBRARY AND CLOTHID_${name}_INCLUDE_DIR AND NOT TARGET clothid::${name})
    add_library(clothid::${name} UNKNOWN IMPORTED)
    set_target_properties(clothid::${name} PROPERTIES
      IMPORTED_LOCATION ${CLOTHID_${name}_LIBRARY}
      INTERFACE_INCLUDE_DIRECTORIES ${CLOTHID_${name}_INCLUDE_DIR})
  endif()
endfunction()
