/* Event ids of @app@. */
#ifndef @APP@_EVENTS_H
#define @APP@_EVENTS_H

@events@

#endif
