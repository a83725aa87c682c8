/* cc shoot.c ./linux-x86_64.so -o shoot && ./shoot */
#include <stdio.h>
#include <string.h>

#include "scene.h"

int main(void) {
  /* a, b [ball radii], elevation, azimuth [rad], speed [m/s] */
  const double stroke[] = {0.0, 0.1, 0.05, 0.05, 4.0};
  memcpy(write_strokes_arguments.offsets, stroke, sizeof stroke);
  write_strokes(&write_strokes_arguments);

  struct play_tables *play = &play_tables_arguments;
  play->strokes.normals = write_strokes_arguments.normals;
  play->strokes.velocities = write_strokes_arguments.velocities;
  play->tables.starts[0].position[1] = 0.05; /* m, of the cue ball */
  play_tables(play); /* before another call, set cues, balls and ends of tables to zeros */

  const TableOutcome *end = play->tables.ends;
  printf("status %d after %.17g s\n", (int)end->status, end->duration);
  for (int i = 0; i < play->tables.balls_shape[0]; i++) {
    const TableBall *ball = &play->tables.balls[i];
    printf("ball %d: %.17g %.17g m", i, ball->position[0], ball->position[1]);
    printf(ball->motion == MOTION_POCKETED ? ", in pocket %d\n" : "\n", (int)ball->pocket);
  }
  return end->status >= STATUS_MISS;
}
