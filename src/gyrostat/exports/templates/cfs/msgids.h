/* Message ids of @app@. Change them here, or define them in the build of the mission: each must be
   used once in a mission. */
#ifndef @APP@_MSGIDS_H
#define @APP@_MSGIDS_H

@ids@
#endif
