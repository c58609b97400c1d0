/** The meanings of fields in German, by their English sentence in the schema, without the unit at its end. */

export const DE_MEANINGS: Record<string, string> = {
  "Centre, [x, y]": "Mittelpunkt, [x, y]",
  "Coefficient of friction of a movable object on the floor.": "Reibungskoeffizient eines beweglichen Gegenstands auf dem Boden.",
  "Dry friction, equal at rest and in motion": "Trockene Reibung, in Ruhe und Bewegung gleich",
  "Group that the studio selects, moves and rotates together; no effect on runs.":
    "Gruppe, die das Studio gemeinsam auswählt, verschiebt und dreht; ohne Wirkung auf Läufe.",
  "Height of its underside above the floor": "Höhe der Unterseite über dem Boden",
  "Its name.": "Der Name.",
  "Kind of drive.": "Art des Antriebs.",
  "Mass of a movable object": "Masse eines beweglichen Gegenstands",
  "Name in errors, events and plans.": "Name in Fehlermeldungen, Ereignissen und Plänen.",
  "Noise of the actual motion relative to the command.": "Rauschen der tatsächlichen Bewegung gegenüber dem Befehl.",
  "Spring stiffness": "Federsteifigkeit",
  "Time; the event happens at the first tick not before it": "Zeit; das Ereignis geschieht im ersten Takt, der nicht davor liegt",
  "Value over time.": "Verlauf über der Zeit.",
  "Viscous damping": "Viskose Dämpfung",
  "Whether a robot can push it.": "Ob ein Roboter es schieben kann.",
};
