# Where ccache is installed, compiles again only what has changed since any build on this machine: sanitised builds and
# fresh checkouts take minutes less. ISOFRONT_WITH_CCACHE=OFF, or a launcher of your own, leaves it out.
option(ISOFRONT_WITH_CCACHE "Compile through ccache where it is installed" ON)
find_program(ISOFRONT_CCACHE ccache)
mark_as_advanced(ISOFRONT_CCACHE)
if(ISOFRONT_WITH_CCACHE AND ISOFRONT_CCACHE)
  foreach(language C CXX)
    if(NOT CMAKE_${language}_COMPILER_LAUNCHER)
      # The folder of a checkout doesn't count, so that all checkouts share what they have in common.
      set(CMAKE_${language}_COMPILER_LAUNCHER
          ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1 ${ISOFRONT_CCACHE})
    endif()
  endforeach()
endif()
